//! What a run shows of itself, and what it leaves.

use std::path::PathBuf;

use estimand::run::{Checkpoint, Reason};
use indicatif::style::TemplateError;
use indicatif::{ProgressBar, ProgressStyle};

/// A bar of so many samples.
pub fn bar(samples: u64) -> Result<ProgressBar, TemplateError> {
    let style = ProgressStyle::with_template("{wide_bar} {percent} % {msg}")?;
    Ok(ProgressBar::new(samples).with_style(style))
}

/// Says where a run that was stopped goes on from; of one that is over, removes the
/// files.
pub fn keep_or_remove(checkpoint: &Checkpoint, reason: Reason) {
    let file = checkpoint.path();
    match checkpoint.last_save() {
        Some(Err(error)) => println!("not saved: {error}"),
        _ if reason == Reason::Cancelled => {
            println!("stopped; the same command goes on from {}", file.display());
        }
        _ => {
            let mut previous = file.as_os_str().to_owned();
            previous.push(".previous");
            // What is not there need not be removed.
            for file in [file.into(), PathBuf::from(previous)] {
                let _ = std::fs::remove_file(file);
            }
        }
    }
}
