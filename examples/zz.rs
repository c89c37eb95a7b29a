//! scratch
use estimand::prelude::*;
use estimand::render::*;
use std::time::Instant;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let n: u64 = std::env::args()
        .nth(1)
        .map_or(1_000_000, |a| a.parse().unwrap_or(0));
    for (name, (scene, camera)) in [
        ("cornell2", scenes::cornell2()?),
        ("small", scenes::small_light()?),
    ] {
        let froms: &[u32] = if n > 50_000 { &[1, 2, 3, 4, 5] } else { &[5] };
        for &from in froms {
            let r = Radiance::new(
                &scene,
                Technique {
                    roulette: Roulette::Throughput(from),
                    ..Technique::path_tracing()
                },
            )?
            .seen_by(camera);
            let mut best = f64::INFINITY;
            let mut err = 0.0;
            for _ in 0..3 {
                let mut m = MonteCarlo::new(r, Independent::new(7));
                let t = Instant::now();
                let a = run(&mut m, &Serial, &Stop::samples(n))?.answer;
                let s = t.elapsed().as_secs_f64();
                best = best.min(s);
                err = a.standard_error.x / a.mean.x * (n as f64).sqrt();
                if n < 50_000 {
                    break;
                }
            }
            let rays = if n > 50_000 {
                run(
                    &mut MonteCarlo::new(r.rays(), Independent::new(7)),
                    &Serial,
                    &Stop::samples(200_000),
                )?
                .answer
                .mean
            } else {
                1.0
            };
            println!(
                "{name} {from} {:.3} Mpaths/s rays {rays:.3} ns/ray {:.1} rel sd {err:.3} eff {:.3}",
                n as f64 / best / 1e6,
                best * 1e9 / n as f64 / rays,
                1e-6 * n as f64 / best / err / err
            );
        }
    }
    Ok(())
}
