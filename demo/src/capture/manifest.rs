//! `capture.json`: its structure on disk, and the checks that turn it into a header and frames.

use super::{CaptureError, CaptureHeader, FrameInfo, MAX_SIDE};
use crate::input_file::printable;
use glam::{Mat4, Vec2};
use serde::{Deserialize, Serialize};
use std::path::{Component, Path};

pub const VERSION: u32 = 1;

/// Letters of a frame's file name, which ends up in messages: what file systems take.
const MOST_FILE_LETTERS: usize = 255;

#[derive(Debug, Serialize, Deserialize)]
pub struct Manifest {
    pub version: u32,
    pub width: u32,
    pub height: u32,
    pub far: f32,
    pub frame_time_s: f32,
    pub frames: Vec<FrameEntry>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FrameEntry {
    pub file: String,
    pub view: Vec<f32>,
    pub projection: Vec<f32>,
    pub jitter_px: Vec<f32>,
    pub restart: bool,
}

/// Read on its own first: other versions may have other fields.
#[derive(Deserialize)]
struct VersionOnly {
    version: u32,
}

impl Manifest {
    pub fn parse(path: &Path, text: &[u8]) -> Result<Self, CaptureError> {
        let json = |error| CaptureError::json(path, &error);
        let VersionOnly { version } = serde_json::from_slice(text).map_err(json)?;
        if version != VERSION {
            return Err(CaptureError::Version { path: path.to_owned(), found: version });
        }
        serde_json::from_slice(text).map_err(json)
    }

    pub fn header(&self, path: &Path) -> Result<CaptureHeader, CaptureError> {
        let header = CaptureHeader {
            width: self.width,
            height: self.height,
            far: self.far,
            frame_time_s: self.frame_time_s,
        };
        check_header(path, &header)?;
        if self.frames.is_empty() {
            return Err(CaptureError::NoFrames { path: path.to_owned() });
        }
        Ok(header)
    }
}

impl FrameEntry {
    pub fn new(file: String, info: &FrameInfo) -> Self {
        Self {
            file,
            view: info.view.to_cols_array().to_vec(),
            projection: info.projection.to_cols_array().to_vec(),
            jitter_px: info.jitter_px.to_array().to_vec(),
            restart: info.restart,
        }
    }

    /// Checks the entry of frame number `frame`.
    pub fn info(&self, path: &Path, frame: usize) -> Result<FrameInfo, CaptureError> {
        let inside = |c| matches!(c, Component::Normal(_) | Component::CurDir);
        if self.file.is_empty() || !Path::new(&self.file).components().all(inside) {
            return Err(CaptureError::FramePath { path: path.to_owned(), frame, file: self.file.clone() });
        }
        if printable(&self.file, MOST_FILE_LETTERS) != self.file {
            let found = printable(&self.file, MOST_FILE_LETTERS).into_owned();
            let expected = format!("a name of at most {MOST_FILE_LETTERS} printable letters");
            return Err(field(path, format!("frames[{frame}].file"), expected, found));
        }
        let Ok(jitter_px) = <[f32; 2]>::try_from(self.jitter_px.as_slice()) else {
            return Err(field(
                path,
                format!("frames[{frame}].jitter_px"),
                "2 numbers",
                format!("{} numbers", self.jitter_px.len()),
            ));
        };
        let info = FrameInfo {
            view: matrix(path, frame, "view", &self.view)?,
            projection: matrix(path, frame, "projection", &self.projection)?,
            jitter_px: Vec2::from(jitter_px),
            restart: self.restart,
        };
        check_info(path, frame, &info)?;
        Ok(info)
    }
}

fn field(path: &Path, field: String, expected: impl ToString, found: impl ToString) -> CaptureError {
    CaptureError::Field {
        path: path.to_owned(),
        field,
        expected: expected.to_string(),
        found: found.to_string(),
    }
}

pub fn check_header(path: &Path, header: &CaptureHeader) -> Result<(), CaptureError> {
    for (name, side) in [("width", header.width), ("height", header.height)] {
        if !(1..=MAX_SIDE).contains(&side) {
            return Err(field(path, name.to_owned(), format!("1 to {MAX_SIDE} pixels"), side));
        }
    }
    if header.far.is_nan() || header.far <= 0.0 {
        return Err(field(path, "far".to_owned(), "a depth above 0", header.far));
    }
    if !(header.frame_time_s.is_finite() && header.frame_time_s >= 0.0) {
        return Err(field(path, "frame_time_s".to_owned(), "seconds, at least 0", header.frame_time_s));
    }
    Ok(())
}

pub fn check_info(path: &Path, frame: usize, info: &FrameInfo) -> Result<(), CaptureError> {
    for (name, matrix) in [("view", info.view), ("projection", info.projection)] {
        let refuse = |problem: &str| {
            Err(CaptureError::Matrix {
                path: path.to_owned(),
                frame,
                matrix: name,
                problem: problem.to_owned(),
            })
        };
        if !matrix.is_finite() {
            return refuse("has an entry that is not finite");
        }
        // In f64, because a small near plane over a large far plane leaves a determinant that f32 may flush to 0.
        let inverse = matrix.as_dmat4().inverse();
        if matrix.as_dmat4().determinant() == 0.0 || !inverse.is_finite() {
            return refuse("cannot be inverted");
        }
        let rotation = glam::Mat3::from_mat4(matrix);
        let rigid = (rotation * rotation.transpose()).abs_diff_eq(glam::Mat3::IDENTITY, 1e-2);
        if name == "view" && (matrix.row(3) != glam::Vec4::W || !rigid || rotation.determinant() < 0.0) {
            return refuse(
                "is not a rotation and a translation, column-major (is it transposed, scaled or mirrored?)",
            );
        }
    }
    if !info.jitter_px.is_finite() {
        return Err(field(path, format!("frames[{frame}].jitter_px"), "finite numbers", info.jitter_px));
    }
    Ok(())
}

fn matrix(path: &Path, frame: usize, name: &'static str, values: &[f32]) -> Result<Mat4, CaptureError> {
    match <[f32; 16]>::try_from(values) {
        Ok(values) => Ok(Mat4::from_cols_array(&values)),
        Err(_) => Err(CaptureError::Matrix {
            path: path.to_owned(),
            frame,
            matrix: name,
            problem: format!("has {} numbers, expected 16", values.len()),
        }),
    }
}
