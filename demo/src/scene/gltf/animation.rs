//! Node animations: translation, rotation and scale; cubic splines are read as lines between their values.

use super::error::fail;
use super::read::File;
use super::{Placed, Result, element};
use crate::scene::{Interpolation, NodeAnimation, Scene, Track};
use glam::{Quat, Vec3};
use gltf::animation::Property;

/// The first animation of the file, looped over its own length.
pub(super) fn load(file: &File, scene: &mut Scene, placed: &Placed<'_>) -> Result<()> {
    let Some(animation) = file.document.animations().next() else {
        return Ok(());
    };
    let mut period = 0.0_f32;
    let mut channels = Vec::new();
    for (i, channel) in animation.channels().enumerate() {
        let what = format!("{}, channel {i}", element("animation", animation.index(), animation.name()));
        let times = file.floats::<1>(&channel.sampler().input(), &what)?;
        let times: Vec<f32> = times.into_iter().map(|[t]| t).collect();
        let ascending = times.windows(2).all(|w| w[0] < w[1]) && times.iter().all(|t| t.is_finite());
        if times.is_empty() || !ascending {
            return fail(&file.path, &what, "its key times are missing or do not ascend");
        }
        period = times.iter().copied().fold(period, f32::max);
        channels.push((channel, times, what));
    }
    for (channel, times, what) in channels {
        let target = channel.target();
        let Some(node) = placed.find(target.node().index()) else {
            continue;
        };
        let output = channel.sampler().output();
        let kind = channel.sampler().interpolation();
        let keys = Keys { file, times: &times, kind, period, what: &what };
        let mut animation = scene.nodes[node].animation.take().unwrap_or_default();
        match target.property() {
            Property::Translation => {
                let track = keys.track(file.floats(&output, &what)?, Vec3::from_array, Vec3::is_finite)?;
                animation.translation = Some(track);
            }
            Property::Rotation => {
                let turn = |q| Quat::from_array(q).normalize();
                animation.rotation = Some(keys.track(file.floats(&output, &what)?, turn, Quat::is_finite)?);
            }
            Property::Scale => {
                let track = keys.track(file.floats(&output, &what)?, Vec3::from_array, Vec3::is_finite)?;
                animation.scale = Some(track);
            }
            Property::MorphTargetWeights => {}
        }
        scene.nodes[node].animation = Some(animation).filter(|a| *a != NodeAnimation::default());
    }
    Ok(())
}

struct Keys<'a> {
    file: &'a File,
    times: &'a [f32],
    kind: gltf::animation::Interpolation,
    period: f32,
    what: &'a str,
}

impl Keys<'_> {
    fn track<const N: usize, T: Copy>(
        &self,
        values: Vec<[f32; N]>,
        convert: impl Fn([f32; N]) -> T,
        is_usable: impl Fn(T) -> bool,
    ) -> Result<Track<T>> {
        // A cubic spline has a tangent before and after each value.
        let is_cubic = self.kind == gltf::animation::Interpolation::CubicSpline;
        let (first, stride) = if is_cubic { (1, 3) } else { (0, 1) };
        if values.len() != self.times.len() * stride {
            let reason = format!("it has {} values for {} keys", values.len(), self.times.len());
            return fail(&self.file.path, self.what, reason);
        }
        let values: Vec<T> = values.into_iter().skip(first).step_by(stride).map(convert).collect();
        if let Some(i) = values.iter().position(|&value| !is_usable(value)) {
            let reason = format!("the value of key {i} is not finite, or no rotation");
            return fail(&self.file.path, self.what, reason);
        }
        let interpolation = match self.kind {
            gltf::animation::Interpolation::Step => Interpolation::Step,
            _ => Interpolation::Linear,
        };
        Ok(Track {
            keys: self.times.iter().copied().zip(values).collect(),
            interpolation,
            period: self.period,
        })
    }
}
