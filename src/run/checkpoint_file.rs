//! A checkpoint on disk.

use core::fmt;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::integrator::StateError;

/// Why a checkpoint could not be written, or was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CheckpointError {
    /// It could not be read or written: no room, no right, no such folder.
    Io {
        /// The file.
        path: PathBuf,
        /// What kind of error that was.
        kind: io::ErrorKind,
        /// What the system says.
        message: String,
    },
    /// The file is no checkpoint of this crate.
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// It was written by a later version of this crate.
    Newer {
        /// The file.
        path: PathBuf,
        /// The number of its format.
        found: u32,
        /// The last one that is known here.
        known: u32,
    },
    /// It is shorter than it says, or longer.
    Length {
        /// The file.
        path: PathBuf,
        /// How many bytes it has.
        found: u64,
        /// How many it should have.
        needed: u64,
    },
    /// Its bytes are not those that were written.
    Corrupt {
        /// The file.
        path: PathBuf,
    },
    /// It is that of another integrator.
    Different {
        /// The file.
        path: PathBuf,
        /// What is not the same.
        what: String,
        /// What it is in the file.
        saved: String,
        /// What it is here.
        present: String,
    },
    /// What was saved does not fit the integrator.
    State {
        /// The file.
        path: PathBuf,
        /// Why.
        error: StateError,
    },
}

impl CheckpointError {
    pub(super) fn io(path: &Path, error: &io::Error) -> Self {
        Self::Io {
            path: path.into(),
            kind: error.kind(),
            message: error.to_string(),
        }
    }
}

impl fmt::Display for CheckpointError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, message, .. } => write!(f, "{}: {message}", path.display()),
            Self::Foreign { path } => write!(f, "{} is no checkpoint", path.display()),
            Self::Newer { path, found, known } => write!(
                f,
                "{} has format {found}, where {known} is the last that is known",
                path.display()
            ),
            Self::Length {
                path,
                found,
                needed,
            } => write!(
                f,
                "{} has {found} bytes, not {needed}; the checkpoint before it is {}",
                path.display(),
                previous(path).display()
            ),
            Self::Corrupt { path } => write!(
                f,
                "{} is damaged; the checkpoint before it is {}",
                path.display(),
                previous(path).display()
            ),
            Self::Different {
                path,
                what,
                saved,
                present,
            } => write!(
                f,
                "{} is of another run: its {what} is {saved}, not {present}",
                path.display()
            ),
            Self::State { path, error } => write!(f, "{}: {error}", path.display()),
        }
    }
}

impl core::error::Error for CheckpointError {}

const MAGIC: [u8; 8] = *b"ESTIMAND";
const FORMAT: u32 = 1;
/// Magic, format, length of the contents, and a checksum of these and of them.
const HEADER: usize = 8 + 4 + 8 + 4;

/// A file's bytes, of its contents.
pub(super) fn wrap(contents: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + contents.len());
    bytes.extend(MAGIC);
    bytes.extend(FORMAT.to_le_bytes());
    bytes.extend((contents.len() as u64).to_le_bytes());
    bytes.extend(checksum(&bytes, contents).to_le_bytes());
    bytes.extend(contents);
    bytes
}

fn checksum(header: &[u8], contents: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(header);
    hasher.update(contents);
    hasher.finalize()
}

/// The contents of a file that was read from `path`.
pub(super) fn unwrap<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a [u8], CheckpointError> {
    let path = || PathBuf::from(path);
    let length = |needed| CheckpointError::Length {
        path: path(),
        found: bytes.len() as u64,
        needed,
    };
    if !bytes.starts_with(&MAGIC) {
        // Nothing, or a beginning of what is ours.
        return Err(if MAGIC.starts_with(bytes) {
            length(HEADER as u64)
        } else {
            CheckpointError::Foreign { path: path() }
        });
    }
    let Some((header, contents)) = bytes.split_at_checked(HEADER) else {
        return Err(length(HEADER as u64));
    };
    let (said, sum) = header.split_at(HEADER - 4);
    let number = |from: usize, len: usize| {
        let digits = said[from..from + len].iter().rev();
        digits.fold(0_u64, |n, &byte| n << 8 | u64::from(byte))
    };
    let format = number(8, 4) as u32;
    if format > FORMAT {
        return Err(CheckpointError::Newer {
            path: path(),
            found: format,
            known: FORMAT,
        });
    }
    let needed = number(12, 8);
    if contents.len() as u64 != needed {
        return Err(length(needed.saturating_add(HEADER as u64)));
    }
    if format != FORMAT || checksum(said, contents).to_le_bytes() != sum {
        return Err(CheckpointError::Corrupt { path: path() });
    }
    Ok(contents)
}

/// The file's bytes; those of the previous one if it was being replaced when the
/// program ended; `None` if there is neither.
pub(super) fn read(path: &Path) -> Result<Option<(PathBuf, Vec<u8>)>, CheckpointError> {
    for path in [path.to_path_buf(), previous(path)] {
        match fs::read(&path) {
            Ok(bytes) => return Ok(Some((path, bytes))),
            Err(error) if error.kind() == io::ErrorKind::NotFound => (),
            Err(error) => return Err(CheckpointError::io(&path, &error)),
        }
    }
    Ok(None)
}

/// Replaces the file, and keeps the one before. Whenever the program ends, one of
/// the two is whole.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), CheckpointError> {
    let new = temporary(path);
    write_new(&new, bytes).map_err(|error| {
        // Half of a file helps nobody, least of all on a full disk.
        let _ = fs::remove_file(&new);
        CheckpointError::io(&new, &error)
    })?;
    replace(path, &new).map_err(|error| CheckpointError::io(path, &error))
}

fn write_new(new: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(new)?;
    file.write_all(bytes)?;
    file.sync_all()
}

fn replace(path: &Path, new: &Path) -> io::Result<()> {
    match fs::rename(path, previous(path)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => (),
    }
    fs::rename(new, path)?;
    // Names are on disk once their folder is; other systems open no folders.
    if cfg!(unix) {
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        File::open(folder.unwrap_or(Path::new(".")))?.sync_all()?;
    }
    Ok(())
}

pub(super) fn previous(path: &Path) -> PathBuf {
    with_suffix(path, ".previous")
}

fn temporary(path: &Path) -> PathBuf {
    with_suffix(path, ".new")
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(suffix);
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A folder of its own for a test.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("estimand-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn contents(path: &Path) -> Vec<u8> {
        let (found, bytes) = read(path).unwrap().unwrap();
        unwrap(&found, &bytes).unwrap().to_vec()
    }

    proptest! {
        /// No file that was cut, prolonged or changed in a bit, or in many, is
        /// taken for one that was not.
        #[test]
        fn what_was_not_written_is_refused(
            contents in prop::collection::vec(any::<u8>(), 0..200),
            flips in prop::collection::vec(any::<prop::sample::Index>(), 1..4),
            end in any::<prop::sample::Index>(),
            more in prop::collection::vec(any::<u8>(), 1..50),
        ) {
            let path = Path::new("a");
            let whole = wrap(&contents);
            prop_assert_eq!(unwrap(path, &whole), Ok(&contents[..]));
            let cut = &whole[..end.index(whole.len())];
            let is_short = matches!(unwrap(path, cut), Err(CheckpointError::Length { .. }));
            prop_assert!(is_short);
            let long = [&whole[..], &more].concat();
            let is_long = matches!(unwrap(path, &long), Err(CheckpointError::Length { .. }));
            prop_assert!(is_long);
            let mut damaged = whole.clone();
            for flip in flips {
                let bit = flip.index(8 * whole.len());
                damaged[bit / 8] ^= 1 << (bit % 8);
            }
            prop_assert!(damaged == whole || unwrap(path, &damaged).is_err());
        }
    }

    /// The control: without the checksum, what is damaged would pass.
    #[test]
    fn the_checksum_is_what_sees_damage() {
        let mut bytes = wrap(b"0123");
        bytes[HEADER] ^= 1;
        let path = PathBuf::from("a");
        assert_eq!(
            unwrap(&path, &bytes),
            Err(CheckpointError::Corrupt { path })
        );
        let sum = checksum(&bytes[..HEADER - 4], &bytes[HEADER..]);
        bytes[HEADER - 4..HEADER].copy_from_slice(&sum.to_le_bytes());
        assert_eq!(unwrap(Path::new("a"), &bytes), Ok(&b"1123"[..]));
    }

    #[test]
    fn foreign_and_newer_files_are_told_apart() {
        let path = PathBuf::from("a");
        let refused = |bytes: &[u8]| unwrap(&path, bytes).unwrap_err();
        let foreign = CheckpointError::Foreign { path: path.clone() };
        assert_eq!(refused(b"\x89PNG\r\n\x1a\n and so on, and on"), foreign);
        let mut newer = wrap(b"what will be");
        newer[8] = 2;
        let (found, known) = (2, 1);
        let error = CheckpointError::Newer {
            path: path.clone(),
            found,
            known,
        };
        assert_eq!(refused(&newer), error);
        assert_eq!(
            error.to_string(),
            "a has format 2, where 1 is the last that is known"
        );
        newer[8] = 0;
        assert_eq!(
            refused(&newer),
            CheckpointError::Corrupt { path: path.clone() }
        );
        let short = "a has 3 bytes, not 24; the checkpoint before it is a.previous";
        assert_eq!(refused(b"EST").to_string(), short);
    }

    /// A program that ends in any of the steps of `write` leaves a whole file, the
    /// old one or the new one; the next save goes through.
    #[test]
    fn whenever_a_save_is_broken_off_there_is_a_whole_file() {
        let folder = folder("steps");
        let path = folder.join("run");
        assert_eq!(read(&path), Ok(None));
        write(&path, &wrap(b"first")).unwrap();
        write(&path, &wrap(b"second")).unwrap();
        assert_eq!(contents(&path), b"second");
        assert_eq!(contents(&previous(&path)), b"first");

        // While the new file is being written: nothing of it counts.
        let third = wrap(b"third");
        for end in 0..=third.len() {
            fs::write(temporary(&path), &third[..end]).unwrap();
            assert_eq!(contents(&path), b"second");
        }
        // Between the two renamings.
        fs::rename(&path, previous(&path)).unwrap();
        assert_eq!(contents(&path), b"second");
        // After the second one.
        fs::rename(temporary(&path), &path).unwrap();
        assert_eq!(contents(&path), b"third");
        assert_eq!(contents(&previous(&path)), b"second");
        // The next save meets what any of these left behind.
        fs::write(
            temporary(&path),
            b"rubbish that is longer than what is written",
        )
        .unwrap();
        write(&path, &wrap(b"fourth")).unwrap();
        assert_eq!(contents(&path), b"fourth");
        fs::remove_file(&path).unwrap();
        write(&path, &wrap(b"fifth")).unwrap();
        assert_eq!(contents(&path), b"fifth");
        assert_eq!(contents(&previous(&path)), b"third");
        fs::remove_dir_all(folder).unwrap();
    }

    /// `/dev/full` is a disk that is: the file that is there stays whole, and
    /// nothing is left over.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_costs_nothing_but_the_save() {
        let folder = folder("full");
        let path = folder.join("run");
        write(&path, &wrap(b"first")).unwrap();
        std::os::unix::fs::symlink("/dev/full", temporary(&path)).unwrap();
        let Err(CheckpointError::Io { kind, .. }) = write(&path, &wrap(b"second")) else {
            panic!("there was room");
        };
        assert_eq!(kind, io::ErrorKind::StorageFull);
        assert_eq!(contents(&path), b"first");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        write(&path, &wrap(b"second")).unwrap();
        assert_eq!(contents(&path), b"second");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn no_folder_is_an_error_that_names_the_file() {
        let path = std::env::temp_dir().join("estimand-there-is-no-such-folder/run");
        let error = write(&path, b"").unwrap_err();
        assert!(error.to_string().contains("no-such-folder"), "{error}");
    }
}
