#![allow(missing_docs, clippy::unwrap_used)]
use estimand::prelude::*;
use estimand::sampler::*;
fn rms<S: Randomize, const D: usize>(
    f: impl Fn([f64; D]) -> f64 + Copy,
    s: impl Fn(u64) -> S,
    n: u64,
    r: u16,
) -> (f64, f64) {
    let mut v = vec![];
    let mut e = vec![];
    for seed in 0..12 {
        let mut q = RandomizedQmc::new(Importance::new(f, UnitCube::<D>), s(seed), r).unwrap();
        let a = run(&mut q, &Serial, &Stop::samples(n)).unwrap().answer;
        v.push(a.mean);
        e.push(a.standard_error);
    }
    let m = v.iter().sum::<f64>() / 12.0;
    let ms = (v.iter().map(|x| (x - m).powi(2)).sum::<f64>() / 11.0).sqrt();
    (
        ms / m.abs(),
        (e.iter().map(|x| x * x).sum::<f64>() / 12.0).sqrt() / m.abs(),
    )
}
fn row<const D: usize>(name: &str, f: impl Fn([f64; D]) -> f64 + Copy) {
    for k in [13u32, 17] {
        let n = 1 << k;
        print!("{name} 2^{k}");
        for (e, s) in [
            rms(f, |s| Sobol::new(D).unwrap().scrambled(Owen, s), n, 8),
            rms(
                f,
                |s| Sobol::new(D).unwrap().scrambled(LinearMatrix, s),
                n,
                8,
            ),
            rms(
                f,
                |s| Interlaced::new(Sobol::new(2 * D).unwrap().scrambled(Owen, s)),
                n,
                8,
            ),
            rms(
                f,
                |s| Interlaced::new(Sobol::new(2 * D).unwrap().scrambled(LinearMatrix, s)),
                n,
                8,
            ),
        ] {
            print!("  {e:.1e} ({s:.1e})");
        }
        println!();
    }
}
fn gauss<const D: usize>(x: [f64; D]) -> f64 {
    (-(0..D)
        .map(|i| {
            let a = 6.0 / D as f64 * (0.7 + 0.6 * i as f64 / D as f64);
            (a * (x[i] - 0.35 - 0.03 * i as f64)).powi(2)
        })
        .sum::<f64>())
    .exp()
}
fn prod<const D: usize>(x: [f64; D]) -> f64 {
    (0..D)
        .map(|i| {
            let a = 8.0 / D as f64 * (0.7 + 0.6 * i as f64 / D as f64);
            1.0 / (1.0 / (a * a) + (x[i] - 0.35 - 0.03 * i as f64).powi(2))
        })
        .product()
}
fn osc<const D: usize>(x: [f64; D]) -> f64 {
    (1.0 + (0..D)
        .map(|i| 8.0 / D as f64 * (0.7 + 0.6 * i as f64 / D as f64) * x[i])
        .sum::<f64>())
    .cos()
}
fn corner<const D: usize>(x: [f64; D]) -> f64 {
    (1.0 + (0..D)
        .map(|i| 2.0 / D as f64 * (0.7 + 0.6 * i as f64 / D as f64) * x[i])
        .sum::<f64>())
    .powi(-(D as i32) - 1)
}
fn kink<const D: usize>(x: [f64; D]) -> f64 {
    (-(0..D)
        .map(|i| {
            let a = 17.0 / D as f64 * (0.7 + 0.6 * i as f64 / D as f64);
            (a * (x[i] - 0.35 - 0.03 * i as f64)).abs()
        })
        .sum::<f64>())
    .exp()
}
fn main() {
    row::<2>("gauss2", gauss::<2>);
    row::<5>("gauss5", gauss::<5>);
    row::<8>("gauss8", gauss::<8>);
    row::<10>("gauss10", gauss::<10>);
    row::<5>("prod5", prod::<5>);
    row::<8>("prod8", prod::<8>);
    row::<5>("osc5", osc::<5>);
    row::<8>("osc8", osc::<8>);
    row::<8>("corner8", corner::<8>);
    row::<5>("kink5", kink::<5>);
}
