//! Reading captures.

use super::channels::Channels;
use super::manifest::{FrameEntry, Manifest};
use super::{CaptureError, CaptureHeader, Frame, FrameInfo, MANIFEST};
use std::path::{Path, PathBuf};

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
        let text = std::fs::read_to_string(&path).map_err(|source| CaptureError::Io {
            path: path.clone(),
            action: "read",
            source,
        })?;
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

    /// Reads the images of a frame.
    pub fn read(&self, frame: usize) -> Result<Frame, CaptureError> {
        let path = self.folder.join(&self.frames[frame].0.file);
        let CaptureHeader { width, height, .. } = self.header;
        let channels = Channels::read(&path, [width, height])?;
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
