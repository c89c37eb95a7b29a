//! The table, as text, CSV and Markdown.

use std::fmt;
use std::fs;
use std::io;

use statrs::distribution::{Binomial, DiscreteCDF};

use crate::limits::limits;
use crate::peers::Peer;

/// What all seeds of an integral came to.
pub struct Row {
    pub name: &'static str,
    pub budget: u64,
    pub seeds: u64,
    /// Of the relative error.
    pub rms: f64,
    /// How many of the 95 % intervals have the exact value.
    pub covered: u64,
    /// Answers in doubt, and how many of their intervals have it.
    pub doubtful: u64,
    pub doubtful_covered: u64,
    pub methods: String,
    /// Parts of the budget: the most that a pilot took, and what was spent on average.
    pub pilot: f64,
    pub spent: f64,
    /// Per evaluation, the least of all seeds, the integrand's own time left out.
    pub nanoseconds: f64,
    pub peer: Option<Peer>,
}

impl Row {
    pub const HEAD: &str = "| integral | budget | RMS error | best peer | ratio | | covered | p | \
                            in doubt | pilot | spent | ns | chosen |";

    /// Ours over the best peer's, and whether it is significantly more.
    fn ratio(&self) -> Option<(f64, bool)> {
        let peer = self.peer.as_ref()?;
        let more = limits(self.rms, self.seeds)[0] > limits(peer.rms, peer.seeds)[1];
        Some((self.rms / peer.rms, more && self.rms > 1e-14))
    }

    /// Answers that nothing speaks against, and how many of their intervals cover.
    fn trusted(&self) -> (u64, u64) {
        (
            self.seeds - self.doubtful,
            self.covered - self.doubtful_covered,
        )
    }

    /// The probability that so few of these cover, or fewer, if each does with
    /// probability .95.
    fn probability(&self) -> f64 {
        let (count, covered) = self.trusted();
        Binomial::new(0.95, count).map_or(f64::NAN, |b| b.cdf(covered))
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "| {} | {:.0e} | {:.1e} |",
            self.name, self.budget as f64, self.rms
        )?;
        match (&self.peer, self.ratio()) {
            (Some(peer), Some((ratio, more))) => write!(
                f,
                " {:.1e} {} | {ratio:.2} | {} |",
                peer.rms,
                peer.name,
                if more { "more" } else { "" }
            )?,
            _ => write!(f, " | | |")?,
        }
        write!(
            f,
            " {}/{} | {:.1e} | {}/{} | {:.1} % | {:.0} % | {:.0} | {} |",
            self.trusted().1,
            self.trusted().0,
            self.probability(),
            self.doubtful_covered,
            self.doubtful,
            100.0 * self.pilot,
            100.0 * self.spent,
            self.nanoseconds,
            self.methods
        )
    }
}

/// Writes both files.
pub fn write(rows: &[Row], times: &str) -> io::Result<()> {
    let mut csv = String::from(
        "integral,budget,seeds,rms_rel_err,covered,doubtful,doubtful_covered,p,pilot,spent,ns,peer,peer_rms\n",
    );
    let mut markdown = format!("{}\n|{}\n", Row::HEAD, "---|".repeat(13));
    for row in rows {
        let peer = row.peer.as_ref();
        csv += &format!(
            "{},{},{},{:e},{},{},{},{:e},{},{},{},{},{:e}\n",
            row.name,
            row.budget,
            row.seeds,
            row.rms,
            row.covered,
            row.doubtful,
            row.doubtful_covered,
            row.probability(),
            row.pilot,
            row.spent,
            row.nanoseconds,
            peer.map_or("", |p| p.name.as_str()),
            peer.map_or(f64::NAN, |p| p.rms)
        );
        markdown += &format!("{row}\n");
    }
    markdown += &format!("\n{times}\n");
    fs::create_dir_all("target")?;
    fs::write("target/battery.csv", csv)?;
    fs::write("target/battery.md", markdown)
}
