//! Ctrl-C.

use estimand::run::Cancel;

/// A switch that Ctrl-C turns, or the SIGTERM of a batch system.
pub fn switch() -> Result<Cancel, ctrlc::Error> {
    let cancel = Cancel::new();
    let switch = cancel.clone();
    ctrlc::set_handler(move || switch.cancel())?;
    Ok(cancel)
}
