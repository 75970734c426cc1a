//! What can be wrong with a file.

use crate::input_file::InputFileError;
use std::path::{Path, PathBuf};

/// Why a glTF file could not be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: InputFileError },
    #[error("{}: not a valid glTF file: {reason}", path.display())]
    Syntax { path: PathBuf, reason: String },
    #[error("{}: {element}: {reason}", path.display())]
    Element { path: PathBuf, element: String, reason: String },
}

pub(super) fn fail<T>(path: &Path, element: &str, reason: impl Into<String>) -> super::Result<T> {
    Err(LoadError::Element { path: path.to_owned(), element: element.to_owned(), reason: reason.into() })
}
