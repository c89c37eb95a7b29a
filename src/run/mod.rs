//! The only loop: runs an integrator's passes until it may stop.

mod driver;
mod executor;
mod progress;
mod stop;

pub use driver::{Finished, Reason, RunError, run, run_with};
#[cfg(feature = "parallel")]
pub use executor::Threads;
pub use executor::{Executor, Pass, Serial};
pub use progress::Progress;
pub use stop::{Cancel, Stop, StopError};
