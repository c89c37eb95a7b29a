//! A row: what the slide prints, what we get, what is true.

use estimand::prelude::Estimate;

/// What the slide prints.
#[derive(Clone, Copy)]
pub enum Slide {
    /// This, and every digit of it is right.
    Prints(&'static str),
    /// This, which is off by a rounding error of its own.
    Slips(&'static str),
    /// Nothing. What no chance enters is then the exact value.
    Silent,
    /// Nothing. Worked out in another way it is the first number, give or take
    /// the second.
    Derived(f64, f64),
}

/// How far two ways to the same number may be apart.
pub const ROUNDING: f64 = 1e-12;

pub fn head() {
    println!("∫₁⁴ (x + 2) dx and what else the lectures integrate\n");
    println!(
        "row {:<36}{:>8}{:>13}{:>10}{:>10}{:>9}",
        "what", "slide", "ours", "exact", "error", "evals"
    );
    println!("{}", "─".repeat(90));
}

pub fn foot() {
    println!("{}", "─".repeat(90));
    println!("13.4998(12) means 13.4998 ± 0.0012, one standard error.");
    println!("~  With the five ξ as the slide prints them the result is ours: 12.15, 13.23 and");
    println!("   14.2807. No digits behind the printed ones give 12.16 and 13.24 both.");
}

/// A value that no chance enters.
pub fn given(row: &str, what: &str, slide: Slide, ours: f64, exact: f64, evaluations: u64) {
    let (expected, within) = match slide {
        Slide::Prints(text) => (text.parse().unwrap_or(f64::NAN), ROUNDING),
        Slide::Slips(text) => (text.parse().unwrap_or(f64::NAN), 0.0101),
        Slide::Silent => (exact, ROUNDING),
        Slide::Derived(expected, within) => (expected, within),
    };
    assert!(
        (ours - expected).abs() <= within,
        "{row}: {what}: {ours}, not {expected}"
    );
    let error = ours - exact;
    print(
        row,
        what,
        slide,
        &format!("{ours:.4}"),
        exact,
        error,
        evaluations,
    );
}

/// An estimate: within five standard errors of the truth, which the slide has.
pub fn random(row: &str, what: &str, slide: Slide, ours: &Estimate<f64>, exact: f64) {
    if let Slide::Prints(text) = slide {
        assert_eq!(text, to_digits_of(text, exact), "{row}: {what}");
    }
    let error = ours.mean - exact;
    assert!(
        error.abs() <= 5.0 * ours.standard_error,
        "{row}: {what}: {ours}"
    );
    print(
        row,
        what,
        slide,
        &ours.to_string(),
        exact,
        error,
        ours.samples(),
    );
}

fn print(row: &str, what: &str, slide: Slide, ours: &str, exact: f64, error: f64, n: u64) {
    let slide = match slide {
        Slide::Prints(text) => text.to_string(),
        Slide::Slips(text) => format!("~{text}"),
        Slide::Silent | Slide::Derived(..) => String::new(),
    };
    // Not −0.0000.
    let error = if error.abs() < 5e-5 { 0.0 } else { error };
    println!("{row:<4}{what:<36}{slide:>8}{ours:>13}{exact:>10.4}{error:>10.4}{n:>9}");
}

/// x with as many decimals as `text` has.
fn to_digits_of(text: &str, x: f64) -> String {
    let decimals = text.split_once('.').map_or(0, |(_, d)| d.len());
    format!("{x:.decimals$}")
}
