//! Why there is no picture.

use core::error::Error;
use core::fmt;
use std::io;
use std::path::PathBuf;

use plotters::drawing::DrawingAreaErrorKind;

/// Why a page could not be drawn or saved.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PageError {
    /// The drawing library refused; its reason.
    Drawing(String),
    /// The file cannot be written.
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        kind: io::ErrorKind,
    },
}

impl fmt::Display for PageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drawing(reason) => write!(f, "cannot draw: {reason}"),
            Self::Unwritable { path, kind } => {
                write!(f, "cannot write {}: {kind}", path.display())
            }
        }
    }
}

impl Error for PageError {}

impl<E: Error + Send + Sync> From<DrawingAreaErrorKind<E>> for PageError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self::Drawing(error.to_string())
    }
}
