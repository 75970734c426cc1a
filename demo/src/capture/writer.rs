//! Writing captures.

use super::manifest::{FrameEntry, Manifest, VERSION, check_header, check_info};
use super::{CaptureError, CaptureHeader, Frame, FrameInfo, MANIFEST};
use crate::image::half_from_f32;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, WritableImage,
};
use half::f16;
use std::path::{Path, PathBuf};

/// `capture.json` while it is being written.
const MANIFEST_PART: &str = "capture.json.part";

/// Streams frames into a capture. It becomes readable with [`finish`](Self::finish).
#[derive(Debug)]
pub struct CaptureWriter {
    folder: PathBuf,
    header: CaptureHeader,
    frames: Vec<FrameEntry>,
}

impl CaptureWriter {
    /// Starts a capture in `folder`, which is created where needed.
    ///
    /// A folder that holds files is refused. With `overwrite` it is emptied first, unless it holds anything that
    /// is not `capture.json` or `frame_<number>.exr`: nothing but a capture is ever deleted.
    pub fn create(folder: &Path, header: CaptureHeader, overwrite: bool) -> Result<Self, CaptureError> {
        check_header(folder, &header)?;
        let io = |action| move |source| CaptureError::Io { path: folder.to_owned(), action, source };
        std::fs::create_dir_all(folder).map_err(io("create the folder"))?;
        let mut old = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(io("list the folder"))? {
            let entry = entry.map_err(io("list the folder"))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
            if !is_file || !is_part_of_a_capture(&name) {
                return Err(CaptureError::Occupied { path: folder.to_owned(), file: Some(name) });
            }
            old.push(entry.path());
        }
        if !old.is_empty() && !overwrite {
            return Err(CaptureError::Occupied { path: folder.to_owned(), file: None });
        }
        // The manifest first, so that what an interruption leaves is not taken for a whole capture.
        old.sort_by_key(|path| !path.ends_with(MANIFEST));
        for path in old {
            std::fs::remove_file(&path).map_err(|source| CaptureError::Io {
                path,
                action: "remove",
                source,
            })?;
        }
        let header = CaptureHeader { far: header.far.min(f32::MAX), ..header };
        Ok(Self { folder: folder.to_owned(), header, frames: Vec::new() })
    }

    /// Writes one frame: radiance, specular radiance, depth, motion, hit distance and reference in 32 bits, the other images in
    /// half precision, integers exactly.
    pub fn write_frame(&mut self, frame: &Frame, info: &FrameInfo) -> Result<(), CaptureError> {
        let file = format!("frame_{:04}.exr", self.frames.len());
        let path = self.folder.join(&file);
        let (expected, found) = ([self.header.width, self.header.height], [frame.width, frame.height]);
        if found != expected {
            return Err(CaptureError::Size { path, image: "frame".to_owned(), expected, found });
        }
        check_planes(&path, frame)?;
        frame.check_split(&path)?;
        check_info(&path, self.frames.len(), info)?;
        let layer = Layer::new(
            (frame.width as usize, frame.height as usize),
            LayerAttributes::default(),
            Encoding {
                compression: Compression::ZIP16,
                blocks: Blocks::ScanLines,
                line_order: LineOrder::Increasing,
            },
            AnyChannels::sort(channels(frame).into_iter().collect()),
        );
        Image::from_layer(layer).write().to_file(&path).map_err(|source| CaptureError::Exr {
            path,
            action: "write",
            source,
        })?;
        self.frames.push(FrameEntry::new(file, info));
        Ok(())
    }

    /// Writes `capture.json`, last and at once: a folder with one is a whole capture.
    pub fn finish(self) -> Result<(), CaptureError> {
        let path = self.folder.join(MANIFEST);
        if self.frames.is_empty() {
            return Err(CaptureError::NoFrames { path });
        }
        let manifest = Manifest {
            version: VERSION,
            width: self.header.width,
            height: self.header.height,
            far: self.header.far,
            frame_time_s: self.header.frame_time_s,
            frames: self.frames,
        };
        let text =
            serde_json::to_string_pretty(&manifest).map_err(|error| CaptureError::json(&path, &error))?;
        let part = self.folder.join(MANIFEST_PART);
        std::fs::write(&part, text)
            .and_then(|()| std::fs::rename(&part, &path))
            .map_err(|source| CaptureError::Io { path, action: "write", source })
    }
}

fn is_part_of_a_capture(name: &str) -> bool {
    let number = name.strip_prefix("frame_").and_then(|rest| rest.strip_suffix(".exr"));
    let numbered = number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()));
    numbered || name == MANIFEST || name == MANIFEST_PART
}

fn check_planes(path: &Path, frame: &Frame) -> Result<(), CaptureError> {
    let expected = frame.width as usize * frame.height as usize;
    let planes = [
        ("radiance", Some(frame.radiance.len())),
        ("albedo", Some(frame.albedo.len())),
        ("normal", Some(frame.normal.len())),
        ("depth", Some(frame.depth.len())),
        ("motion", Some(frame.motion.len())),
        ("motion_depth", frame.motion_depth.as_ref().map(Vec::len)),
        ("roughness", frame.roughness.as_ref().map(Vec::len)),
        ("surface_id", frame.surface_id.as_ref().map(Vec::len)),
        ("emission", frame.emission.as_ref().map(Vec::len)),
        ("samples", frame.samples.as_ref().map(Vec::len)),
        ("specular", frame.specular.as_ref().map(Vec::len)),
        ("specular_albedo", frame.specular_albedo.as_ref().map(Vec::len)),
        ("hit_distance", frame.hit_distance.as_ref().map(Vec::len)),
        ("reference", frame.reference.as_ref().map(Vec::len)),
    ];
    for (image, found) in planes {
        if let Some(found) = found.filter(|&found| found != expected) {
            return Err(CaptureError::PlaneLength { path: path.to_owned(), image, expected, found });
        }
    }
    Ok(())
}

fn channels(frame: &Frame) -> Vec<AnyChannel<FlatSamples>> {
    let mut list = Vec::new();
    let mut add = |name: String, samples| list.push(AnyChannel::new(name.as_str(), samples));
    let mut vectors = |group: &str, names: [&str; 3], values: &[[f32; 3]], half: bool| {
        for (c, name) in names.into_iter().enumerate() {
            let channel = values.iter().map(|v| v[c]);
            let samples = if half {
                FlatSamples::F16(channel.map(half_from_f32).collect::<Vec<f16>>())
            } else {
                FlatSamples::F32(channel.collect())
            };
            add(format!("{group}.{name}"), samples);
        }
    };
    const RGB: [&str; 3] = ["R", "G", "B"];
    vectors("radiance", RGB, &frame.radiance, false);
    vectors("albedo", RGB, &frame.albedo, true);
    vectors("normal", ["X", "Y", "Z"], &frame.normal, true);
    for (group, plane, half) in [
        ("emission", &frame.emission, true),
        ("specular", &frame.specular, false),
        ("specular_albedo", &frame.specular_albedo, true),
        ("reference", &frame.reference, false),
    ] {
        if let Some(values) = plane {
            vectors(group, RGB, values, half);
        }
    }
    let mut floats = |name: &str, values: Vec<f32>| add(name.to_owned(), FlatSamples::F32(values));
    floats("depth.Z", frame.depth.clone());
    floats("motion.X", frame.motion.iter().map(|m| m[0]).collect());
    floats("motion.Y", frame.motion.iter().map(|m| m[1]).collect());
    for (name, plane) in [("motion.Z", &frame.motion_depth), ("hit_distance.Y", &frame.hit_distance)] {
        if let Some(values) = plane {
            floats(name, values.clone());
        }
    }
    if let Some(roughness) = &frame.roughness {
        let half = roughness.iter().map(|&r| half_from_f32(r)).collect();
        add("roughness.Y".to_owned(), FlatSamples::F16(half));
    }
    for (name, plane) in [("surface.id", &frame.surface_id), ("samples.N", &frame.samples)] {
        if let Some(values) = plane {
            add(name.to_owned(), FlatSamples::U32(values.clone()));
        }
    }
    list
}
