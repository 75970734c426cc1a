//! Reading captures.

use super::channels::Channels;
use super::manifest::{FrameEntry, Manifest};
use super::{CaptureError, CaptureHeader, Frame, FrameInfo, MANIFEST};
use crate::input_file::{self, Folder, InputFileError};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Bytes of `capture.json`: a hundred thousand frames, as `record` writes them.
const MOST_MANIFEST_BYTES: u64 = 128 << 20;
/// Bytes of a frame's file: all channels at the largest size, in 32 bits and uncompressed, and half as much again.
const MOST_FRAME_BYTES: u64 = 12 << 30;

/// An opened capture; frames are read one at a time.
#[derive(Debug)]
pub struct CaptureReader {
    folder: PathBuf,
    header: CaptureHeader,
    frames: Vec<(FrameEntry, FrameInfo)>,
}

impl CaptureReader {
    /// Reads and checks `capture.json`. The frames' files are not touched yet.
    pub fn open(folder: &Path) -> Result<Self, CaptureError> {
        let path = folder.join(MANIFEST);
        let text = Folder::new(folder)
            .map_err(InputFileError::Io)
            .and_then(|folder| input_file::read(&folder.resolve(Path::new(MANIFEST))?, MOST_MANIFEST_BYTES));
        let text = text.map_err(|error| refused(&path, "read", error))?;
        let manifest = Manifest::parse(&path, &text)?;
        let header = manifest.header(&path)?;
        let frames = manifest.frames.into_iter().enumerate();
        let frames = frames
            .map(|(i, entry)| {
                let info = entry.info(&path, i)?;
                Ok((entry, info))
            })
            .collect::<Result<_, CaptureError>>()?;
        Ok(Self { folder: folder.to_owned(), header, frames })
    }

    pub fn header(&self) -> &CaptureHeader {
        &self.header
    }

    /// Frames in the capture, at least 1.
    #[allow(clippy::len_without_is_empty, reason = "a capture without frames is refused")]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Camera of a frame.
    ///
    /// # Panics
    /// Where `frame` is not below [`len`](Self::len), as are all methods that take one.
    pub fn info(&self, frame: usize) -> FrameInfo {
        self.frames[frame].1
    }

    fn open_file(&self, file: &Path) -> Result<File, InputFileError> {
        input_file::open(&Folder::new(&self.folder)?.resolve(file)?, MOST_FRAME_BYTES)
    }

    /// Reads the images of a frame.
    pub fn read(&self, frame: usize) -> Result<Frame, CaptureError> {
        let file = Path::new(&self.frames[frame].0.file);
        let path = self.folder.join(file);
        let CaptureHeader { width, height, .. } = self.header;
        let file = self.open_file(file).map_err(|error| refused(&path, "open", error))?;
        let channels = Channels::read(&path, file, [width, height])?;
        let rgb = |group: &str| -> Result<Vec<[f32; 3]>, CaptureError> {
            channels.vectors(["R", "G", "B"].map(|c| format!("{group}.{c}")).each_ref().map(String::as_str))
        };
        let optional_rgb = |group: &str| -> Result<Option<Vec<[f32; 3]>>, CaptureError> {
            let names = ["R", "G", "B"].map(|c| format!("{group}.{c}"));
            // One of the three is a mistake worth an error; none is a choice.
            channels.has_any(&names.each_ref().map(String::as_str)).then(|| rgb(group)).transpose()
        };
        let optional = |name: &str| channels.has_any(&[name]).then(|| channels.floats(name)).transpose();
        let optional_integers =
            |name: &str| channels.has_any(&[name]).then(|| channels.integers(name)).transpose();
        let frame = Frame {
            width,
            height,
            radiance: rgb("radiance")?,
            albedo: rgb("albedo")?,
            normal: channels.vectors(["normal.X", "normal.Y", "normal.Z"])?,
            depth: channels.floats("depth.Z")?,
            motion: channels.vectors(["motion.X", "motion.Y"])?,
            motion_depth: optional("motion.Z")?,
            roughness: optional("roughness.Y")?,
            surface_id: optional_integers("surface.id")?,
            emission: optional_rgb("emission")?,
            samples: optional_integers("samples.N")?,
            specular: optional_rgb("specular")?,
            specular_albedo: optional_rgb("specular_albedo")?,
            hit_distance: optional("hit_distance.Y")?,
            reference: optional_rgb("reference")?,
        };
        frame.check_split(&path)?;
        Ok(frame)
    }
}

fn refused(path: &Path, action: &'static str, error: InputFileError) -> CaptureError {
    let path = path.to_owned();
    match error {
        InputFileError::Io(source) => CaptureError::Io { path, action, source },
        source => CaptureError::File { path, action, source },
    }
}
