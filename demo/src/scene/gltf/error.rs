//! What can be wrong with a file.

use crate::input_file::{InputFileError, printable};
use std::path::{Path, PathBuf};

/// Why a glTF file could not be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    #[error("{}: cannot be read", path.display())]
    Read { path: PathBuf, source: InputFileError },
    #[error("{}: not a valid glTF file: {reason}", path.display())]
    Syntax { path: PathBuf, reason: String },
    #[error("{}: {element}: {reason}", path.display())]
    Element { path: PathBuf, element: String, reason: String },
}

/// What a reason quotes of a file may be long.
pub(super) const MOST_REASON_LETTERS: usize = 600;

pub(super) fn fail<T>(path: &Path, element: &str, reason: impl Into<String>) -> super::Result<T> {
    let reason = printable(&reason.into(), MOST_REASON_LETTERS).into_owned();
    Err(LoadError::Element { path: path.to_owned(), element: element.to_owned(), reason })
}
