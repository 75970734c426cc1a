//! What can be wrong with a capture. Every message names the file, the thing, what was expected and what came.

use crate::input_file::{InputFileError, printable};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a capture could not be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CaptureError {
    /// The file system refused.
    #[error("{}: cannot {action}", path.display())]
    Io {
        path: PathBuf,
        action: &'static str,
        #[source]
        source: std::io::Error,
    },
    /// Not a regular file, too large, or outside the capture's folder.
    #[error("{}: cannot {action}", path.display())]
    File {
        path: PathBuf,
        action: &'static str,
        #[source]
        source: InputFileError,
    },
    /// The manifest is not JSON, or lacks a field, or has one of the wrong type.
    #[error("{}: not a valid capture description: {reason}", path.display())]
    Json { path: PathBuf, reason: String },
    /// A newer or unknown format.
    #[error("{}: version is {found}, expected 1", path.display())]
    Version { path: PathBuf, found: u32 },
    /// A capture without frames.
    #[error("{}: has no frames, expected at least one", path.display())]
    NoFrames { path: PathBuf },
    /// A number outside its range.
    #[error("{}: `{field}` is {found}, expected {expected}", path.display())]
    Field { path: PathBuf, field: String, expected: String, found: String },
    /// A frame's file lies, or may lie, outside the capture's folder.
    #[error("{}: frame {frame}: file `{}` leaves the capture's folder", path.display(), printable(file, 120))]
    FramePath { path: PathBuf, frame: usize, file: String },
    /// A matrix cannot be used.
    #[error("{}: frame {frame}: `{matrix}` {problem}", path.display())]
    Matrix { path: PathBuf, frame: usize, matrix: &'static str, problem: String },
    /// The file is no OpenEXR file, is truncated, or uses something that cannot be read.
    #[error("{}: cannot {action} OpenEXR", path.display())]
    Exr {
        path: PathBuf,
        action: &'static str,
        #[source]
        source: exr::error::Error,
    },
    /// The file is damaged in a way that its decoder does not survive.
    #[error("{}: cannot read OpenEXR: the file is damaged", path.display())]
    Damaged { path: PathBuf },
    /// A file claims more than it, or any frame, can hold.
    #[error("{}: cannot read OpenEXR: {what} has {found} {unit}, expected at most {most}", path.display())]
    TooMuch { path: PathBuf, what: String, unit: &'static str, found: u64, most: u64 },
    /// A needed channel is missing, or an optional group is incomplete.
    #[error("{}: channel `{channel}` is missing; the file has {}", path.display(), found.join(", "))]
    MissingChannel { path: PathBuf, channel: String, found: Vec<String> },
    /// Channels of one name leave open which is meant.
    #[error("{}: channel `{channel}` is there more than once", path.display())]
    DuplicateChannel { path: PathBuf, channel: String },
    /// A channel is subsampled or deep.
    #[error("{}: channel `{channel}` is {found}, expected one value per pixel", path.display())]
    ChannelLayout { path: PathBuf, channel: String, found: String },
    /// An integer channel holds something else.
    #[error(
        "{}: channel `{channel}` has {found} at pixel ({x}, {y}), expected a whole number from 0 to 4294967295",
        path.display()
    )]
    NotAnInteger { path: PathBuf, channel: String, x: u32, y: u32, found: f32 },
    /// An image does not have the capture's size.
    #[error("{}: `{image}` is {}x{}, expected {}x{} as the capture says", path.display(),
        found[0], found[1], expected[0], expected[1])]
    Size { path: PathBuf, image: String, expected: [u32; 2], found: [u32; 2] },
    /// A plane of a frame to be written has the wrong length.
    #[error("{}: `{image}` has {found} pixels, expected {expected}", path.display())]
    PlaneLength { path: PathBuf, image: &'static str, expected: usize, found: usize },
    /// An optional image is there without another one that it says something about.
    #[error("{}: has `{image}` but no `{needed}`, which it belongs to", path.display())]
    Alone { path: PathBuf, image: &'static str, needed: &'static str },
    /// The folder to write to holds something.
    #[error("{}: folder is not empty{}", path.display(), match file {
        Some(file) => format!(", and `{file}` in it is no part of a capture, so it is not overwritten"),
        None => " (it holds a capture); pass --overwrite to replace it".to_owned(),
    })]
    Occupied { path: PathBuf, file: Option<String> },
}

impl CaptureError {
    /// serde quotes what it finds, however long.
    pub(super) fn json(path: &Path, error: &serde_json::Error) -> Self {
        let place = format!(" (line {}, column {})", error.line(), error.column());
        let text = error.to_string();
        let mut reason = printable(&text, 300).into_owned();
        if reason.len() < text.len() && error.line() > 0 {
            reason.push_str(&place);
        }
        Self::Json { path: path.to_owned(), reason }
    }
}
