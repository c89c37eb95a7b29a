//! The only loop: runs an integrator's passes until it may stop.

#[cfg(feature = "serde")]
mod checkpoint;
#[cfg(feature = "serde")]
mod checkpoint_file;
mod driver;
mod executor;
mod progress;
#[cfg(feature = "mpi")]
mod ranks;
mod stop;

#[cfg(feature = "serde")]
pub use checkpoint::{Checkpoint, ResumeError, Save, resume};
#[cfg(feature = "serde")]
pub use checkpoint_file::CheckpointError;
pub use driver::{Finished, Reason, RunError, run, run_with};
#[cfg(feature = "parallel")]
pub use executor::Threads;
pub use executor::{Executor, Pass, Serial};
pub use progress::Progress;
#[cfg(feature = "mpi")]
pub use ranks::{Ranks, Traffic};
pub use stop::{Cancel, Stop, StopError};
