//! What the README shows is what its program prints.

use estimand::prelude::*;

#[test]
fn the_output_in_the_readme_is_that_of_its_program() {
    let f = |x| x + 2.0;
    let budget = Stop::samples(100_000);
    let p = Linear::new(1.0, 4.0, 1.0, 4.0).unwrap();
    let strata = Stratified::new([50_000], 2, 7).unwrap();
    let uniform = Importance::new(f, Interval::new(1.0, 4.0).unwrap());
    let mut integrator = StratifiedMonteCarlo::new(uniform, strata);
    let printed = format!(
        "one call     {}\nuniform      {}\nimportance   {}\nstratified   {}\n",
        integrate(f, 1.0..4.0, &budget).unwrap(),
        monte_carlo(f, 1.0..4.0, &budget).unwrap(),
        monte_carlo(f, p, &budget).unwrap(),
        run(&mut integrator, &Serial, &budget).unwrap(),
    );
    assert!(include_str!("../README.md").contains(&printed), "{printed}");
}
