#![allow(missing_docs, dead_code, clippy::unwrap_used)]
// Own integrals for tuning, none of the public ones.
use std::f64::consts::{PI, TAU};
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum K {
    Osc,
    Prod,
    Corner,
    Gauss,
    Kink,
    Jump,
    Peak(f64),
    Diag(f64),
    Peaks2,
    Peaks4,
    Pole(f64),
    Shell(f64, f64),
    LogP,
    Rot,
}
#[derive(Clone, Copy)]
pub struct I {
    pub name: &'static str,
    pub d: usize,
    pub k: K,
    pub s: f64,
    pub exact: f64,
}
const U: [f64; 12] = [
    0.57, 0.22, 0.71, 0.36, 0.64, 0.83, 0.29, 0.44, 0.51, 0.18, 0.77, 0.6,
];
fn q(f: impl Fn(f64) -> f64, cut: &[f64]) -> f64 {
    use estimand::{estimate::Tolerance, pdf::Interval, quadrature::adaptive};
    let mut c = vec![0.0];
    c.extend(cut.iter().copied().filter(|c| *c > 0.0 && *c < 1.0));
    c.push(1.0);
    c.sort_by(f64::total_cmp);
    c.windows(2)
        .filter(|w| w[1] > w[0])
        .map(|w| {
            adaptive(
                &f,
                Interval::new(w[0], w[1]).unwrap(),
                &Tolerance::either(1e-15, 1e-14).unwrap(),
                100_000,
            )
            .unwrap()
            .value
        })
        .sum()
}
impl I {
    fn a(&self, i: usize) -> f64 {
        let d = self.d as f64;
        let w = |i: usize| 1.5 - (i as f64 + 0.5) / d;
        self.s * w(i) / d
    }
    pub fn at(&self, x: &[f64]) -> f64 {
        let d = self.d;
        let a = |i: usize| self.a(i);
        let ap = |c: f64| x.iter().map(|x| (x - c) * (x - c)).sum::<f64>();
        match self.k {
            K::Osc => (1.3 + (0..d).map(|i| a(i) * x[i]).sum::<f64>()).cos(),
            K::Prod => (0..d)
                .map(|i| 1.0 / (1.0 / (a(i) * a(i)) + (x[i] - U[i]).powi(2)))
                .product(),
            K::Corner => (1.0 + (0..d).map(|i| a(i) * x[i]).sum::<f64>()).powi(-(d as i32) - 1),
            K::Gauss => (-(0..d).map(|i| (a(i) * (x[i] - U[i])).powi(2)).sum::<f64>()).exp(),
            K::Kink => (-(0..d).map(|i| a(i) * (x[i] - U[i]).abs()).sum::<f64>()).exp(),
            K::Jump => {
                if x[0] > U[0] || x[1] > 0.8 {
                    0.0
                } else {
                    (0..d).map(|i| a(i) * x[i]).sum::<f64>().exp()
                }
            }
            K::Peak(w) => (-(0..d).map(|i| ((x[i] - U[i]) / w).powi(2)).sum::<f64>()).exp(),
            K::Diag(w) => (0..200)
                .map(|j| {
                    let c = 0.3 + 0.3 * j as f64 / 199.0;
                    (-ap(c) / (w * w)).exp()
                })
                .sum::<f64>(),
            K::Peaks2 => {
                (-120.0 * ap(0.3)).exp()
                    + 0.5
                        * (-80.0
                            * (0..d)
                                .map(|i| (x[i] - if i % 2 == 0 { 0.65 } else { 0.4 }).powi(2))
                                .sum::<f64>())
                        .exp()
            }
            K::Peaks4 => (0..4)
                .map(|p| {
                    (-60.0
                        * (0..d)
                            .map(|i| {
                                (x[i]
                                    - (0.2
                                        + 0.6 * (((p * 7 + i * 3 + p * i * 2) % 11) as f64 / 10.0)))
                                    .powi(2)
                            })
                            .sum::<f64>())
                    .exp()
                })
                .sum(),
            K::Pole(p) => x.iter().map(|x| x.max(1e-300).powf(-p)).product(),
            K::Shell(a, b) => {
                let r = ap(0.5);
                f64::from(u8::from(r >= a * a && r < b * b))
            }
            K::LogP => x
                .iter()
                .map(|x| -(1.0 - x).max(1e-300).ln() * (1.0 + x))
                .product(),
            K::Rot => {
                let s: f64 = x.iter().sum::<f64>() - d as f64 * 0.55;
                (-(s * 6.0 / d as f64).powi(2)).exp() * (1.0 + x[0])
            }
        }
    }
    fn value(&self) -> f64 {
        let d = self.d;
        let a = |i: usize| self.a(i);
        let g = |c: f64, w: f64| q(|x| (-((x - c) / w).powi(2)).exp(), &[c - w, c, c + w]);
        match self.k {
            K::Osc => {
                let (mut re, mut im) = (1.3f64.cos(), 1.3f64.sin());
                for i in 0..d {
                    let (r, m) = (a(i).sin() / a(i), (1.0 - a(i).cos()) / a(i));
                    (re, im) = (re * r - im * m, re * m + im * r);
                }
                re
            }
            K::Prod => (0..d)
                .map(|i| a(i) * ((a(i) * (1.0 - U[i])).atan() + (a(i) * U[i]).atan()))
                .product(),
            K::Corner => {
                let mut s = 0.0;
                for m in 0..1u32 << d {
                    let t: f64 = (0..d).filter(|i| m >> i & 1 == 1).map(a).sum();
                    s += if m.count_ones() % 2 == 0 { 1.0 } else { -1.0 } / (1.0 + t);
                }
                let f: f64 = (1..=d).map(|k| k as f64).product();
                s / f / (0..d).map(a).product::<f64>()
            }
            K::Gauss => (0..d).map(|i| g(U[i], 1.0 / a(i))).product(),
            K::Kink => (0..d)
                .map(|i| q(|x| (-a(i) * (x - U[i]).abs()).exp(), &[U[i]]))
                .product(),
            K::Jump => (0..d)
                .map(|i| {
                    let e = if i == 0 {
                        U[0]
                    } else if i == 1 {
                        0.8
                    } else {
                        1.0
                    };
                    (a(i) * e).exp_m1() / a(i)
                })
                .product(),
            K::Peak(w) => (0..d).map(|i| g(U[i], w)).product(),
            K::Diag(w) => (0..200)
                .map(|j| g(0.3 + 0.3 * j as f64 / 199.0, w).powi(d as i32))
                .sum(),
            K::Peaks2 => {
                g(0.3, 1.0 / 120f64.sqrt()).powi(d as i32)
                    + 0.5
                        * (0..d)
                            .map(|i| g(if i % 2 == 0 { 0.65 } else { 0.4 }, 1.0 / 80f64.sqrt()))
                            .product::<f64>()
            }
            K::Peaks4 => (0..4)
                .map(|p| {
                    (0..d)
                        .map(|i| {
                            g(
                                0.2 + 0.6 * (((p * 7 + i * 3 + p * i * 2) % 11) as f64 / 10.0),
                                1.0 / 60f64.sqrt(),
                            )
                        })
                        .product::<f64>()
                })
                .sum(),
            K::Pole(p) => (1.0 / (1.0 - p)).powi(d as i32),
            K::Shell(a, b) => {
                let v = match d {
                    3 => 4.0 * PI / 3.0,
                    5 => 8.0 * PI * PI / 15.0,
                    6 => PI.powi(3) / 6.0,
                    _ => PI,
                };
                v * (b.powi(d as i32) - a.powi(d as i32))
            }
            K::LogP => 1.75f64.powi(d as i32),
            K::Rot => f64::NAN,
        }
    }
}
pub fn all() -> Vec<I> {
    let mut v = vec![];
    let mut add = |name, d, k, s| {
        let mut i = I {
            name,
            d,
            k,
            s,
            exact: 0.0,
        };
        i.exact = i.value();
        v.push(i)
    };
    add("osc3", 3, K::Osc, 11.0);
    add("osc6", 6, K::Osc, 8.0);
    add("osc9", 9, K::Osc, 10.0);
    add("prod3", 3, K::Prod, 9.0);
    add("prod6", 6, K::Prod, 8.0);
    add("prod9", 9, K::Prod, 6.5);
    add("corn3", 3, K::Corner, 2.5);
    add("corn7", 7, K::Corner, 2.0);
    add("gaus3", 3, K::Gauss, 9.0);
    add("gaus6", 6, K::Gauss, 8.0);
    add("gaus9", 9, K::Gauss, 6.5);
    add("gaus12", 12, K::Gauss, 7.0);
    add("kink2", 2, K::Kink, 17.0);
    add("kink4", 4, K::Kink, 22.0);
    add("kink7", 7, K::Kink, 19.0);
    add("kink9", 9, K::Kink, 22.0);
    add("jump3", 3, K::Jump, 3.5);
    add("jump6", 6, K::Jump, 5.0);
    add("jump9", 9, K::Jump, 4.0);
    add("peak3", 3, K::Peak(0.08), 0.0);
    add("peak5", 5, K::Peak(0.13), 0.0);
    add("diag3", 3, K::Diag(0.08), 0.0);
    add("diag5", 5, K::Diag(0.12), 0.0);
    add("two6", 6, K::Peaks2, 0.0);
    add("two8", 7, K::Peaks2, 0.0);
    add("four5", 5, K::Peaks4, 0.0);
    add("four7", 7, K::Peaks4, 0.0);
    add("pole2", 2, K::Pole(0.4), 0.0);
    add("pole4", 4, K::Pole(0.45), 0.0);
    add("pole7", 7, K::Pole(0.45), 0.0);
    add("shell3", 3, K::Shell(0.41, 0.43), 0.0);
    add("shell6", 6, K::Shell(0.42, 0.46), 0.0);
    add("log3", 3, K::LogP, 0.0);
    add("log6", 6, K::LogP, 0.0);
    v
}
struct S<'a>(&'a I);
impl S<'_> {
    fn f<const D: usize>(&self, x: [f64; D]) -> f64 {
        self.0.at(&x)
    }
}
use estimand::estimator::Mapped;
use estimand::integrator::{Automatic, Learning};
use estimand::pdf::AdaptiveGrid;
use estimand::prelude::*;
use estimand::sampler::Owen;
fn one<const D: usize>(i: &I, n: u64, seeds: u64, all: bool) {
    let mean = |v: &[(f64, f64, f64)]| {
        let r =
            (v.iter().map(|p| (p.0 / i.exact - 1.0).powi(2)).sum::<f64>() / v.len() as f64).sqrt();
        let c = v.iter().filter(|p| (p.0 - i.exact).abs() <= p.2).count() as f64 / v.len() as f64;
        format!("{r:.1e}[{:.0}%]", 100.0 * c)
    };
    let est = Importance::new(|x: [f64; D]| i.at(&x), UnitCube::<D>);
    let tri = |e: &Estimate<f64>| {
        (
            e.mean,
            e.standard_error,
            (e.interval(0.95).unwrap().high - e.mean),
        )
    };
    let mut ours = vec![];
    let mut methods = std::collections::BTreeMap::new();
    let mut proms: std::collections::BTreeMap<String, f64> = Default::default();
    let mut pilot = 0.0f64;
    let mut calls = 0;
    for s in 0..seeds {
        let mut a = Automatic::new(&est, D, 1000 + s).unwrap();
        let f = run(&mut a, &Threads, &Stop::samples(n)).unwrap();
        calls += a.spent();
        ours.push(tri(&f.answer.estimate));
        let c = f.answer.choice.clone().unwrap();
        *methods
            .entry(format!("{:?}/{:?}", c.method, c.why))
            .or_insert(0) += 1;
        pilot = pilot.max(c.pilot as f64 / n as f64);
        for p in &c.promises {
            *proms.entry(format!("{:?}", p.method)).or_default() +=
                (p.error / i.exact).abs().ln() / seeds as f64;
        }
    }
    print!(
        "{:7} {} pilot {:.1}% spent {:.0}% {:?} | promised {}",
        i.name,
        mean(&ours),
        100.0 * pilot,
        100.0 * calls as f64 / (n * seeds) as f64,
        methods,
        proms
            .iter()
            .map(|(k, v)| format!("{k} {:.1e}", v.exp()))
            .collect::<Vec<_>>()
            .join(" ")
    );
    if all {
        let mut net = vec![];
        let mut map = vec![];
        let mut veg = vec![];
        for s in 0..seeds.min(8) {
            let k = (n / 8).ilog2();
            let r = (n >> k) as u16;
            let mut q =
                RandomizedQmc::new(&est, Sobol::new(D).unwrap().scrambled(Owen, s), r).unwrap();
            net.push(tri(&run(&mut q, &Threads, &Stop::samples(n))
                .unwrap()
                .answer));
            let mut v = Vegas::new(&est, D, s).unwrap();
            veg.push(tri(&run(&mut v, &Threads, &Stop::samples(n))
                .unwrap()
                .answer));
            let mut v = Vegas::from_grid(
                &est,
                AdaptiveGrid::new(D, 1).unwrap(),
                s,
                Learning {
                    share: 0.97,
                    ..Default::default()
                },
            )
            .unwrap();
            run(&mut v, &Threads, &Stop::samples(n / 5)).unwrap();
            let m = n * 4 / 5;
            let k = (m / 8).ilog2();
            let r = (m >> k) as u16;
            let mut q = RandomizedQmc::new(
                Mapped::new(v.grid(), &est),
                Sobol::new(D).unwrap().scrambled(Owen, s),
                r,
            )
            .unwrap();
            map.push(tri(&run(&mut q, &Threads, &Stop::samples(m))
                .unwrap()
                .answer));
        }
        print!(
            " | pure Net {} Map {} Veg {}",
            mean(&net),
            mean(&map),
            mean(&veg)
        );
    }
    println!();
}
fn cub<const D: usize>(i: &I) {
    use estimand::quadrature::*;
    print!("{:7}", i.name);
    for deg in [Degree::Nine, Degree::Seven] {
        let mut a = Adaptive::new(|x: [f64; D]| i.at(&x), UnitCube::<D>, deg).unwrap();
        for n in [3e3, 3e4, 1e5, 1e6] {
            if let Ok(c) = a.refine(&Tolerance::absolute(1e-300).unwrap(), n as u64) {
                print!(
                    " {:.0e}: {:.1e} ({:.1e})",
                    n,
                    (c.value / i.exact - 1.0f64).abs(),
                    c.error / i.exact
                );
            }
        }
        print!(" | ");
    }
    println!();
}
fn main() {
    if std::env::args().nth(1).as_deref() == Some("cub") {
        for i in all() {
            let i = &i;
            match i.d {
                2 => cub::<2>(i),
                3 => cub::<3>(i),
                4 => cub::<4>(i),
                5 => cub::<5>(i),
                6 => cub::<6>(i),
                7 => cub::<7>(i),
                9 => cub::<9>(i),
                12 => cub::<12>(i),
                _ => {}
            }
        }
        return;
    }
    let a: Vec<String> = std::env::args().collect();
    let n: u64 = a[1].parse::<f64>().unwrap() as u64;
    let seeds: u64 = a[2].parse().unwrap();
    let pure = a.get(3).is_some_and(|x| x == "pure");
    let only = a.get(4);
    for i in all()
        .iter()
        .filter(|i| only.is_none_or(|o| o.split(',').any(|o| i.name.starts_with(o))))
    {
        match i.d {
            1 => one::<1>(i, n, seeds, pure),
            2 => one::<2>(i, n, seeds, pure),
            3 => one::<3>(i, n, seeds, pure),
            4 => one::<4>(i, n, seeds, pure),
            5 => one::<5>(i, n, seeds, pure),
            6 => one::<6>(i, n, seeds, pure),
            7 => one::<7>(i, n, seeds, pure),
            9 => one::<9>(i, n, seeds, pure),
            12 => one::<12>(i, n, seeds, pure),
            _ => {}
        }
    }
    let _ = TAU;
}
