//! What was counted, and which cells fall short.

use estimand::verify::{sidak, tail};

/// One integral by one method with one budget.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    pub integral: &'static str,
    pub method: &'static str,
    pub budget: u64,
    pub seeds: u64,
    pub covered: u64,
    pub trusted: u64,
    pub covered_trusted: u64,
    /// Σ (b − a)/|I| of the intervals that are finite, and how many they are.
    widths: f64,
    finite: u64,
}

impl Cell {
    pub const HEAD: &str =
        "integral,method,budget,seeds,covered,trusted,covered_and_trusted,relative_width";

    pub const fn new(
        integral: &'static str,
        method: &'static str,
        budget: u64,
        seeds: u64,
    ) -> Self {
        Self {
            integral,
            method,
            budget,
            seeds,
            covered: 0,
            trusted: 0,
            covered_trusted: 0,
            widths: 0.0,
            finite: 0,
        }
    }

    pub fn push(&mut self, covered: bool, trusted: bool, width: f64) {
        self.covered += u64::from(covered);
        self.trusted += u64::from(trusted);
        self.covered_trusted += u64::from(covered && trusted);
        if width.is_finite() {
            self.widths += width;
            self.finite += 1;
        }
    }

    pub fn all(&self) -> f64 {
        self.covered as f64 / self.seeds as f64
    }

    /// Coverage among the trusted; `None` where there are none.
    pub fn among_trusted(&self) -> Option<f64> {
        (self.trusted > 0).then(|| self.covered_trusted as f64 / self.trusted as f64)
    }

    fn width(&self) -> f64 {
        self.widths / self.finite as f64
    }

    pub fn csv(&self) -> String {
        format!(
            "{},{},{},{},{},{},{},{:.4e}",
            self.integral,
            self.method,
            self.budget,
            self.seeds,
            self.covered,
            self.trusted,
            self.covered_trusted,
            self.width()
        )
    }
}

/// Those where the exact binomial test rejects that the trusted cover with
/// probability 0.95 or more, one-sided, all of them together at the level 10⁻³.
pub fn short(cells: &[Cell]) -> impl Iterator<Item = &Cell> {
    let level = sidak(1e-3, cells.len());
    cells.iter().filter(move |c| {
        c.trusted > 0 && tail::binomial(c.covered_trusted, c.trusted, 0.95) < level
    })
}

/// A block for each budget; `width` is over the least of the methods'.
pub fn print(cells: &[Cell]) {
    for group in cells.chunk_by(|a, b| a.budget == b.budget) {
        println!("{} evaluations: coverage at 95 %\n", group[0].budget);
        println!(
            "{:<11}{:<13}{:>6}{:>8}{:>10}{:>10}{:>8}",
            "", "", "seeds", "all", "trusted", "doubtful", "width"
        );
        for row in group.chunk_by(|a, b| a.integral == b.integral) {
            let least = row.iter().map(Cell::width).fold(f64::INFINITY, f64::min);
            for cell in row {
                let trusted = cell
                    .among_trusted()
                    .map_or("—".into(), |c| format!("{c:.3}"));
                let doubtful = (cell.seeds - cell.trusted) as f64 / cell.seeds as f64;
                println!(
                    "{:<11}{:<13}{:>6}{:>8.3}{trusted:>10}{:>8.1} %{:>8.1}",
                    cell.integral,
                    cell.method,
                    cell.seeds,
                    cell.all(),
                    100.0 * doubtful,
                    cell.width() / least
                );
            }
        }
        println!();
    }
    let level = sidak(1e-3, cells.len());
    println!(
        "Of {} cells, these cover less than 95 % among the trusted (exact binomial test, \
         each at {level:.1e}):",
        cells.len()
    );
    for c in short(cells) {
        println!(
            "  {} {} {}: {} of {}",
            c.integral, c.method, c.budget, c.covered_trusted, c.trusted
        );
    }
}
