//! A2: what a rule costs in k dimensions.

use std::error::Error;

use estimand::pdf::UnitCube;
use estimand::prelude::*;
use estimand::quadrature::{QuadratureError, Rule, tensor};

const NODES: u64 = 10;
const BUDGET: u64 = 1_000_000;

pub fn table() -> Result<(), Box<dyn Error>> {
    println!("\nA2  The mean of x² over the k-dimensional cube, 1/3: N = 10 midpoints an axis");
    println!("    cost Nᵏ; beside them, 100 000 random points\n");
    println!(
        "{:>6}{:>10}{:>16}{:>11}{:>20}{:>12}",
        "k", "Nᵏ", "midpoint", "error", "random", "error"
    );
    println!("{}", "─".repeat(75));
    row::<1>()?;
    row::<2>()?;
    row::<4>()?;
    row::<6>()?;
    row::<8>()?;
    row::<20>()?;
    println!("{}", "─".repeat(75));
    println!("A budget of {BUDGET} evaluations; what is above it is refused before the first.");
    Ok(())
}

fn row<const K: usize>() -> Result<(), Box<dyn Error>> {
    const EXACT: f64 = 1.0 / 3.0;
    // 10²⁰ is more than 64 bits count.
    let cost = NODES.checked_pow(K as u32);
    assert_eq!(Rule::midpoint().evaluations(NODES, K as u32), cost);
    let f = |x: [f64; K]| x.iter().map(|x| x * x).sum::<f64>() / K as f64;
    let (fixed, error) = match tensor(&Rule::midpoint(), f, [const { 0.0..1.0 }; K], NODES, BUDGET)
    {
        Ok(fixed) => {
            // h²/12 whatever k is: the cost grows, the error stays.
            assert!((EXACT - fixed - 1.0 / 1200.0).abs() < 1e-12);
            (format!("{fixed:.6}"), format!("{:.6}", fixed - EXACT))
        }
        Err(QuadratureError::Budget { .. }) => {
            assert!(cost.is_none_or(|cost| cost > BUDGET));
            ("refused".into(), String::new())
        }
        Err(other) => return Err(other.into()),
    };
    let random = monte_carlo(f, UnitCube::<K>, &Stop::samples(100_000))?.answer;
    let off = random.mean - EXACT;
    assert!(off.abs() <= 5.0 * random.standard_error);
    println!(
        "{K:>6}{:>10}{fixed:>16}{error:>11}{:>20}{off:>12.6}",
        format!("10^{K}"),
        random.to_string()
    );
    Ok(())
}
