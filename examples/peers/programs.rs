//! Other programs, as far as they are installed.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use estimand::chart::Found;

/// What runs it.
#[derive(Clone, Copy)]
enum By {
    C,
    Python,
    Rust,
}

/// A method of a program.
#[derive(Clone, Copy)]
pub struct Peer {
    pub name: &'static str,
    /// Whether another seed makes another answer, always.
    pub samples: bool,
    by: By,
    method: &'static str,
}

const fn peer(name: &'static str, by: By, method: &'static str) -> Peer {
    Peer {
        name,
        samples: true,
        by,
        method,
    }
}

const fn rule(name: &'static str, method: &'static str) -> Peer {
    Peer {
        samples: false,
        ..peer(name, By::C, method)
    }
}

/// All that are known.
pub const PEERS: [Peer; 12] = [
    peer("GSL miser", By::C, "miser"),
    peer("GSL vegas", By::C, "vegas"),
    peer("Cuba Vegas", By::C, "VegasTuned"),
    rule("Cuba Divonne", "Divonne"),
    rule("Cuba Cuhre", "Cuhre"),
    rule("hcubature", "hcubature"),
    peer("vegas", By::Python, "vegas_plus"),
    peer("SciPy qmc_quad", By::Python, "qmc_quad_sobol"),
    peer("QMCPy net", By::Python, "CubQMCNetG"),
    peer("sobol_burley", By::Rust, "rqmc"),
    peer("mchep", By::Rust, "vegasplus"),
    peer("numerica", By::Rust, "grid"),
];

/// A run of one of them on the integral of that name.
pub struct Run {
    pub integral: String,
    pub found: Found,
}

impl Peer {
    /// One run a seed, on one integral or on all of them, by the program in `folder`;
    /// one run alone where seeds make no difference.
    pub fn runs(
        &self,
        folder: &Path,
        budget: u64,
        seeds: u32,
        integral: Option<&str>,
    ) -> Result<Vec<Run>, String> {
        let seeds = if self.samples { seeds } else { 1 };
        let mut command = match self.by {
            By::C => Command::new(folder.join("bench_c")),
            By::Rust => Command::new(folder.join("rustpeers/target/release/rustpeers")),
            By::Python => {
                let python = env::var_os("ESTIMAND_PYTHON").unwrap_or_else(|| "python3".into());
                let mut command = Command::new(python);
                command.arg("bench_py.py");
                command
            }
        };
        command
            .arg(self.method)
            .args([budget.to_string(), seeds.to_string()])
            .args(integral)
            .current_dir(folder)
            .env("RAYON_NUM_THREADS", "1")
            // The folder may be read-only.
            .env("NUMBA_CACHE_DIR", cache())
            .env("PYTHONDONTWRITEBYTECODE", "1");
        let output = command
            .output()
            .map_err(|e| format!("{}: {e}", command.get_program().to_string_lossy()))?;
        let text = String::from_utf8_lossy(&output.stdout);
        let runs: Vec<Run> = text.lines().filter_map(run).collect();
        if runs.is_empty() {
            let errors = String::from_utf8_lossy(&output.stderr);
            let last = errors.lines().last().unwrap_or("it knows no such method");
            return Err(last.into());
        }
        Ok(runs)
    }
}

fn cache() -> PathBuf {
    env::var_os("NUMBA_CACHE_DIR").map_or_else(|| env::temp_dir().join("numba"), PathBuf::from)
}

/// peer, method, integral, dimension, budget, seed, estimate, error, evaluations,
/// seconds
fn run(line: &str) -> Option<Run> {
    let cells: Vec<&str> = line.split(',').collect();
    let number = |k: usize| cells.get(k)?.parse::<f64>().ok();
    Some(Run {
        integral: cells.get(2)?.to_string(),
        found: Found {
            seconds: Some(number(9)?),
            ..Found::new(number(6)?, number(7)?, number(8)? as u64)
        },
    })
}
