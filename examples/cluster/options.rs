//! What is asked for on the command line.

use std::path::PathBuf;
use std::time::Duration;

#[derive(Clone, Copy)]
pub enum What {
    Plain,
    Vegas,
    Film,
}

pub struct Options {
    pub what: What,
    pub samples: u64,
    pub threads: bool,
    pub measure: bool,
    pub checkpoint: Option<PathBuf>,
    pub every: Duration,
    pub panic: Option<u32>,
}

impl Options {
    pub fn read() -> Result<Self, Box<dyn std::error::Error>> {
        let mut arguments = std::env::args().skip(1);
        let what = match arguments.next().as_deref() {
            None | Some("plain") => What::Plain,
            Some("vegas") => What::Vegas,
            Some("film") => What::Film,
            Some(other) => return Err(format!("{other} is none of plain, vegas, film").into()),
        };
        let mut options = Self {
            what,
            samples: match what {
                What::Plain => 8_000_000,
                What::Vegas => 2_000_000,
                What::Film => 64 * 64 * 100,
            },
            threads: false,
            measure: false,
            checkpoint: None,
            every: Duration::from_secs(300),
            panic: None,
        };
        while let Some(option) = arguments.next() {
            let mut value = || {
                let value = arguments.next();
                value.ok_or_else(|| format!("{option} takes a value"))
            };
            match option.as_str() {
                "--threads" => options.threads = true,
                "--measure" => options.measure = true,
                "--samples" => options.samples = value()?.parse()?,
                "--checkpoint" => options.checkpoint = Some(value()?.into()),
                "--every" => options.every = Duration::try_from_secs_f64(value()?.parse()?)?,
                "--panic" => options.panic = Some(value()?.parse()?),
                _ => return Err(format!("{option} is not known").into()),
            }
        }
        Ok(options)
    }
}
