//! The channels of one OpenEXR file, by name, whatever their order, sample type and compression.

use super::CaptureError;
use super::decode::ExrFile;
use crate::input_file::printable;
use exr::meta::header::Header;
use exr::prelude::FlatSamples;
use std::collections::HashMap;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Every channel that a capture knows.
const KNOWN: [&str; 29] = [
    "radiance.R",
    "radiance.G",
    "radiance.B",
    "albedo.R",
    "albedo.G",
    "albedo.B",
    "normal.X",
    "normal.Y",
    "normal.Z",
    "depth.Z",
    "motion.X",
    "motion.Y",
    "motion.Z",
    "roughness.Y",
    "surface.id",
    "emission.R",
    "emission.G",
    "emission.B",
    "samples.N",
    "specular.R",
    "specular.G",
    "specular.B",
    "specular_albedo.R",
    "specular_albedo.G",
    "specular_albedo.B",
    "hit_distance.Y",
    "reference.R",
    "reference.G",
    "reference.B",
];

pub struct Channels {
    path: PathBuf,
    width: u32,
    samples: HashMap<String, FlatSamples>,
    /// All names in the file, for messages.
    names: Vec<String>,
}

/// A part of a multi-part file may be named after the group (`radiance`) and hold bare channels (`R`).
pub fn full_name(layer: Option<&exr::prelude::Text>, channel: &exr::prelude::Text) -> String {
    let channel = channel.to_string();
    match layer {
        Some(layer) if !is_known(&channel) && is_known(&format!("{layer}.{channel}")) => {
            format!("{layer}.{channel}")
        }
        _ => channel,
    }
}

pub fn is_known(name: &str) -> bool {
    KNOWN.contains(&name)
}

impl Channels {
    /// Reads the known channels of a file whose size must be `size`. `path` is for messages.
    pub fn read(path: &Path, file: File, size: [u32; 2]) -> Result<Self, CaptureError> {
        let file = ExrFile::open(path, file)?;
        let names = check_headers(path, file.headers(), size)?;
        let samples = file.known_samples()?;
        Ok(Self { path: path.to_owned(), width: size[0], samples, names })
    }

    pub fn has_any(&self, names: &[&str]) -> bool {
        names.iter().any(|&name| self.samples.contains_key(name))
    }

    pub fn floats(&self, channel: &str) -> Result<Vec<f32>, CaptureError> {
        match self.samples.get(channel) {
            Some(samples) => Ok(samples.values_as_f32().collect()),
            None => Err(CaptureError::MissingChannel {
                path: self.path.clone(),
                channel: channel.to_owned(),
                found: listed(&self.names),
            }),
        }
    }

    /// Interleaves `N` channels.
    pub fn vectors<const N: usize>(&self, channels: [&str; N]) -> Result<Vec<[f32; N]>, CaptureError> {
        let mut out = Vec::new();
        for (c, channel) in channels.into_iter().enumerate() {
            let values = self.floats(channel)?;
            out.resize(values.len(), [0.0; N]);
            for (vector, value) in out.iter_mut().zip(values) {
                vector[c] = value;
            }
        }
        Ok(out)
    }

    /// Whole numbers, exact when stored as u32; float channels are taken where each value is one.
    pub fn integers(&self, channel: &str) -> Result<Vec<u32>, CaptureError> {
        if let Some(FlatSamples::U32(values)) = self.samples.get(channel) {
            return Ok(values.clone());
        }
        let values = self.floats(channel)?;
        let wrong = |value: f32| !(0.0..=u32::MAX as f32).contains(&value) || value.fract() != 0.0;
        if let Some((i, &found)) = values.iter().enumerate().find(|&(_, &value)| wrong(value)) {
            let (x, y) = (i as u32 % self.width, i as u32 / self.width);
            let channel = channel.to_owned();
            return Err(CaptureError::NotAnInteger { path: self.path.clone(), channel, x, y, found });
        }
        Ok(values.into_iter().map(|value| value as u32).collect())
    }
}

/// A file may have thousands, with names of any length.
fn listed(names: &[String]) -> Vec<String> {
    const MOST_NAMES: usize = 40;
    const MOST_LETTERS: usize = 60;
    let mut list: Vec<String> =
        names.iter().take(MOST_NAMES).map(|name| printable(name, MOST_LETTERS).into_owned()).collect();
    if names.len() > MOST_NAMES {
        list.push(format!("{} more", names.len() - MOST_NAMES));
    }
    list
}

/// Names of all channels, after checking the known ones.
fn check_headers(path: &Path, headers: &[Header], expected: [u32; 2]) -> Result<Vec<String>, CaptureError> {
    let mut names = Vec::new();
    for header in headers {
        for channel in &header.channels.list {
            let name = full_name(header.own_attributes.layer_name.as_ref(), &channel.name);
            let layout = |found: String| {
                Err(CaptureError::ChannelLayout { path: path.to_owned(), channel: name.clone(), found })
            };
            if is_known(&name) {
                if names.contains(&name) {
                    return Err(CaptureError::DuplicateChannel { path: path.to_owned(), channel: name });
                }
                if header.deep {
                    return layout("deep".to_owned());
                }
                if channel.sampling != exr::math::Vec2(1, 1) {
                    return layout(format!("subsampled {}x{}", channel.sampling.x(), channel.sampling.y()));
                }
                let found = [header.layer_size.width() as u32, header.layer_size.height() as u32];
                if found != expected {
                    return Err(CaptureError::Size { path: path.to_owned(), image: name, expected, found });
                }
            }
            names.push(name);
        }
    }
    Ok(names)
}
