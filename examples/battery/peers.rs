//! What other programs were measured at.

use std::error::Error;
use std::fs;

/// The measurements of a file.
pub struct Peers(Vec<Peer>);

/// One measurement.
#[derive(Clone, Debug)]
pub struct Peer {
    pub name: String,
    pub rms: f64,
    pub seeds: u64,
    integral: String,
    budget: u64,
}

impl Peers {
    /// Those of a file, or none.
    pub fn read(path: Option<&str>) -> Result<Self, Box<dyn Error>> {
        let Some(path) = path else {
            return Ok(Self(Vec::new()));
        };
        let text = fs::read_to_string(path)?;
        let mut lines = text.lines();
        let head: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let column = |name: &str| {
            let found = head.iter().position(|h| *h == name);
            found.ok_or(format!("{path} has no column {name}"))
        };
        let names = [
            "peer",
            "method",
            "integral",
            "budget",
            "rms_rel_err",
            "nseeds",
        ];
        let columns = names
            .map(column)
            .into_iter()
            .collect::<Result<Vec<_>, _>>()?;
        let peer = |line: &str| -> Option<Peer> {
            let cells: Vec<&str> = line.split(',').collect();
            let cell = |k: usize| cells.get(columns[k]).copied();
            Some(Peer {
                name: format!("{}/{}", cell(0)?, cell(1)?),
                integral: cell(2)?.into(),
                budget: cell(3)?.parse().ok()?,
                rms: cell(4)?.parse().ok()?,
                seeds: cell(5)?.parse().ok()?,
            })
        };
        Ok(Self(lines.filter_map(peer).collect()))
    }

    /// The one with the smallest error, of those with ten seeds or more.
    pub fn best(&self, integral: &str, budget: u64) -> Option<Peer> {
        let fits = |p: &&Peer| p.integral == integral && p.budget == budget && p.seeds >= 10;
        let best = self
            .0
            .iter()
            .filter(fits)
            .min_by(|a, b| a.rms.total_cmp(&b.rms));
        best.cloned()
    }
}
