//! The channels of one OpenEXR file, by name, whatever their order, sample type and compression.

use super::CaptureError;
use super::guard::guarded;
use exr::meta::MetaData;
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
use std::collections::HashMap;
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
fn full_name(layer: Option<&exr::prelude::Text>, channel: &exr::prelude::Text) -> String {
    let channel = channel.to_string();
    match layer {
        Some(layer) if !is_known(&channel) && is_known(&format!("{layer}.{channel}")) => {
            format!("{layer}.{channel}")
        }
        _ => channel,
    }
}

fn is_known(name: &str) -> bool {
    KNOWN.contains(&name)
}

impl Channels {
    /// Reads the known channels of a file whose size must be `size`.
    pub fn read(path: &Path, size: [u32; 2]) -> Result<Self, CaptureError> {
        let error = |source| CaptureError::Exr { path: path.to_owned(), action: "read", source };
        let file = std::fs::File::open(path).map_err(|source| CaptureError::Io {
            path: path.to_owned(),
            action: "open",
            source,
        })?;
        let panicked = || CaptureError::Damaged { path: path.to_owned() };
        // Before any pixels: a wrong size in the file must not become an allocation of that size.
        let meta = guarded(|| MetaData::read_from_unbuffered(file, false));
        let meta = meta.ok_or_else(panicked)?.map_err(error)?;
        let names = check_meta(path, &meta, size)?;
        // On this thread: a panic on one of the decoder's own would end the program.
        let reader = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .non_parallel();
        let image = guarded(|| reader.from_file(path)).ok_or_else(panicked)?.map_err(error)?;
        let mut samples = HashMap::new();
        for layer in image.layer_data {
            let layer_name = layer.attributes.layer_name;
            for channel in layer.channel_data.list {
                let name = full_name(layer_name.as_ref(), &channel.name);
                if is_known(&name) {
                    samples.insert(name, channel.sample_data);
                }
            }
        }
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
                found: self.names.clone(),
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

/// Names of all channels, after checking the known ones.
fn check_meta(path: &Path, meta: &MetaData, expected: [u32; 2]) -> Result<Vec<String>, CaptureError> {
    let mut names = Vec::new();
    for header in &meta.headers {
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
