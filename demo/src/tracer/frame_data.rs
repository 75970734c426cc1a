//! What changes from frame to frame: the uniform buffer and the texels of instances, emission and lights.

use super::geometry::{Emitter, Geometry};
use super::{FrameView, Sampling, Strategy, TraceSettings};
use crate::scene::{Pose, PunctualKind, Scene, Sun};
use glam::{Affine3A, Mat4, Vec2, Vec3, Vec4};

const INSTANCE_TEXELS: usize = 10;
const PUNCTUAL_TEXELS: usize = 4;

/// `Frame` of the shaders. What hardly changes comes first: Mesa's CPU driver compiles a shader anew when the first words of its
/// uniforms change.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct FrameUniform {
    size: [u32; 2],
    material_frame_offset: u32,
    punctual_offset: u32,
    light_offset: u32,
    instance_count: u32,
    punctual_count: u32,
    light_count: u32,
    spp: f32,
    max_bounces: u32,
    strategy: u32,
    frame_index: u32,
    seed: u32,
    sampling: u32,
    jitter_px: Vec2,
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
    offset_floor: f32,
    view_from_world: Mat4,
    prev_view_from_world: Mat4,
    projection: Vec4,
    prev_projection: Vec4,
    eye: Vec4,
    sun_direction: Vec4,
    sun_radiance: Vec4,
    sky_zenith: Vec4,
    sky_horizon: Vec4,
    sky_ground: Vec4,
    light_choice: Vec4,
}

/// Size of a ray's offset from its surface over the size of its position: some tens of f32 roundings.
const RELATIVE_OFFSET: f32 = 1e-5;

/// The parts of a scene that frames are made from.
#[derive(Debug)]
pub(super) struct FrameSource {
    scene: Scene,
    placed: Vec<super::geometry::Placed>,
    emitters: Vec<Emitter>,
    /// Mean luminance of each material's emissive image; 1 without one.
    emissive_means: Vec<f32>,
    radius: f32,
}

impl FrameSource {
    pub fn new(scene: &Scene, geometry: &mut Geometry) -> Self {
        let (low, high) = scene.bounds();
        // Positions, images and meshes are on the GPU from here on.
        let mut scene = scene.clone();
        let emissive_means = emissive_means(&scene);
        scene.meshes.clear();
        scene.images.clear();
        Self {
            scene,
            placed: std::mem::take(&mut geometry.placed),
            emitters: std::mem::take(&mut geometry.emitters),
            emissive_means,
            radius: 0.5 * (high - low).length(),
        }
    }

    /// Texels that `texels` returns.
    pub fn texel_count(&self) -> usize {
        self.light_offset() + self.emitters.len()
    }

    fn material_offset(&self) -> usize {
        self.placed.len() * INSTANCE_TEXELS
    }

    fn punctual_offset(&self) -> usize {
        self.material_offset() + self.scene.materials.len()
    }

    fn light_offset(&self) -> usize {
        self.punctual_offset() + self.scene.punctual_lights.len() * PUNCTUAL_TEXELS
    }

    /// The frame's uniform and its texels.
    pub fn frame(
        &self,
        view: &FrameView,
        settings: &TraceSettings,
        size: [u32; 2],
    ) -> (FrameUniform, Vec<Vec4>) {
        let pose = self.scene.pose(view.time_s);
        let (prev_camera, prev_time) = view.previous.unwrap_or((view.camera, view.time_s));
        let prev_pose = if prev_time == view.time_s { pose.clone() } else { self.scene.pose(prev_time) };
        let (texels, power) = self.texels(&pose, &prev_pose);
        let choice = [power > 0.0, self.scene.sun.is_some(), !self.scene.punctual_lights.is_empty()]
            .map(|present| if present { 1.0_f32 } else { 0.0 });
        let kinds = choice.iter().sum::<f32>().max(1.0);
        let (sun_direction, sun_radiance) = sun_disc(self.scene.sun.as_ref());
        let eye = |camera: &quell::Camera| camera.view_from_world.inverse().w_axis;
        let pixel_angle = 2.0 / (view.camera.clip_from_view.y_axis.y.abs() * size[1] as f32);
        let uniform = FrameUniform {
            view_from_world: view.camera.view_from_world,
            prev_view_from_world: prev_camera.view_from_world,
            projection: projection(&view.camera),
            prev_projection: projection(&prev_camera),
            eye: eye(&view.camera).truncate().extend(RELATIVE_OFFSET),
            sun_direction,
            sun_radiance,
            sky_zenith: self.scene.sky.zenith.extend(0.0),
            sky_horizon: self.scene.sky.horizon.extend(0.0),
            sky_ground: self.scene.sky.ground.extend(0.0),
            light_choice: Vec3::from(choice.map(|c| c / kinds)).extend(pixel_angle),
            jitter_px: view.camera.jitter_px,
            size,
            material_frame_offset: self.material_offset() as u32,
            punctual_offset: self.punctual_offset() as u32,
            light_offset: self.light_offset() as u32,
            instance_count: self.placed.len() as u32,
            punctual_count: self.scene.punctual_lights.len() as u32,
            light_count: self.emitters.len() as u32,
            spp: settings.spp,
            sampling: match settings.sampling {
                Sampling::Uniform => 0,
                Sampling::Checkerboard => 1,
                Sampling::Adaptive => 2,
            },
            max_bounces: settings.max_bounces,
            strategy: match settings.strategy {
                Strategy::Mis => 0,
                Strategy::LightsOnly => 1,
                Strategy::BsdfOnly => 2,
            },
            frame_index: settings.frame,
            seed: settings.seed,
            pad_0: 0,
            pad_1: 0,
            pad_2: 0,
            offset_floor: 0.1 * self.radius,
        };
        (uniform, texels)
    }

    /// Also returns the summed power of the emitters.
    fn texels(&self, pose: &Pose, prev_pose: &Pose) -> (Vec<Vec4>, f32) {
        let mut texels = Vec::with_capacity(self.texel_count());
        let world_of = |placed: &super::geometry::Placed, pose: &Pose| {
            placed.node.map_or(Affine3A::IDENTITY, |node| pose.world_from_node[node])
        };
        for placed in &self.placed {
            let world = world_of(placed, pose);
            texels.extend(rows(&world.inverse()));
            texels.extend(rows(&world));
            texels.extend(rows(&world_of(placed, prev_pose)));
            texels.push(Vec4::new(placed.root as f32, placed.surface_base as f32, 0.0, 0.0));
        }

        let luminance = |m: usize| {
            let [r, g, b] = self.scene.materials[m].emissive;
            (0.2126 * r + 0.7152 * g + 0.0722 * b) * self.emissive_means[m] * pose.emission_scales[m]
        };
        let brightness: Vec<f32> = (0..self.scene.materials.len()).map(luminance).collect();
        let power_of = |emitter: &Emitter| {
            let world = world_of(&self.placed[emitter.placed], pose);
            let [e1, e2] = emitter.edges.map(|e| world.transform_vector3(e));
            0.5 * e1.cross(e2).length() * brightness[emitter.material]
        };
        let powers: Vec<f32> = self.emitters.iter().map(power_of).collect();
        let total = powers.iter().map(|&p| f64::from(p)).sum::<f64>() as f32;
        let density = |m: usize| if total > 0.0 { brightness[m] / total } else { 0.0 };
        texels
            .extend((0..brightness.len()).map(|m| Vec4::new(pose.emission_scales[m], density(m), 0.0, 0.0)));

        for light in &self.scene.punctual_lights {
            texels.extend(punctual(light, &pose.world_from_node[light.node]));
        }
        for (emitter, (keep, other)) in self.emitters.iter().zip(alias_table(&powers)) {
            texels.push(Vec4::new(emitter.triangle as f32, emitter.placed as f32, keep, other as f32));
        }
        (texels, total)
    }
}

/// Walker's alias table (Vose 1991): per column, the probability to keep it and the column to take otherwise.
fn alias_table(weights: &[f32]) -> Vec<(f32, usize)> {
    let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
    let mut table: Vec<(f32, usize)> = (0..weights.len()).map(|i| (1.0, i)).collect();
    if total <= 0.0 {
        return table;
    }
    let mut rest: Vec<f64> = weights.iter().map(|&w| f64::from(w) * weights.len() as f64 / total).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..rest.len()).partition(|&i| rest[i] < 1.0);
    while let (Some(poor), Some(&rich)) = (small.pop(), large.last()) {
        table[poor] = (rest[poor] as f32, rich);
        rest[rich] -= 1.0 - rest[poor];
        if rest[rich] < 1.0 {
            large.pop();
            small.push(rich);
        }
    }
    table
}

fn emissive_means(scene: &Scene) -> Vec<f32> {
    let mean = |material: &crate::scene::Material| {
        let image = &scene.images[material.emissive_texture?.image];
        let linear = |b: u8| (f32::from(b) / 255.0).powf(2.2);
        let light = |t: &[u8]| 0.2126 * linear(t[0]) + 0.7152 * linear(t[1]) + 0.0722 * linear(t[2]);
        let texels = image.rgba.chunks_exact(4);
        let count = texels.len().max(1) as f32;
        Some(texels.map(light).sum::<f32>() / count)
    };
    scene.materials.iter().map(|m| mean(m).unwrap_or(1.0)).collect()
}

fn rows(m: &Affine3A) -> [Vec4; 3] {
    let t = Mat4::from(*m).transpose();
    [t.x_axis, t.y_axis, t.z_axis]
}

fn punctual(light: &crate::scene::PunctualLight, world: &Affine3A) -> [Vec4; PUNCTUAL_TEXELS] {
    let axis = -world.transform_vector3(Vec3::Z).normalize_or(Vec3::Z);
    let place = Vec3::from(world.translation);
    // Scale and offset of the cosine that KHR_lights_punctual recommends; (0, 1) lights all round.
    let (kind, cone) = match light.kind {
        PunctualKind::Directional => (0.0, Vec2::Y),
        PunctualKind::Point => (1.0, Vec2::Y),
        PunctualKind::Spot { inner, outer } => {
            let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-3);
            (1.0, Vec2::new(scale, -outer.cos() * scale))
        }
    };
    [place.extend(kind), axis.extend(light.range), light.intensity.extend(0.0), cone.extend(0.0).extend(0.0)]
}

/// `sun_direction` and `sun_radiance` of the uniform.
fn sun_disc(sun: Option<&Sun>) -> (Vec4, Vec4) {
    let Some(sun) = sun else {
        return (Vec3::Y.extend(0.0), Vec4::ZERO);
    };
    let half = 0.5 * f64::from(sun.angular_radius.max(1e-4));
    // 1 - cos(2 x) = 2 sin(x)^2 keeps its digits.
    let fall = 2.0 * half.sin().powi(2);
    let solid_angle = std::f64::consts::TAU * fall;
    let radiance = sun.irradiance / solid_angle as f32;
    (sun.direction.normalize_or(Vec3::Y).extend(fall as f32), radiance.extend((1.0 / solid_angle) as f32))
}

fn projection(camera: &quell::Camera) -> Vec4 {
    let p = camera.clip_from_view;
    Vec4::new(p.x_axis.x, p.y_axis.y, p.z_axis.x, p.z_axis.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use wgpu::naga;

    macro_rules! fields {
        ($($field:ident),* $(,)?) => {
            vec![$((stringify!($field), offset_of!(FrameUniform, $field))),*]
        };
    }

    #[test]
    fn uniform_has_the_layout_of_the_shaders() {
        let source = crate::tracer::shaders::source("trace").expect("all includes exist");
        let module = naga::front::wgsl::parse_str(&source).expect("parses");
        let is_frame = |(_, ty): &(_, &naga::Type)| ty.name.as_deref() == Some("Frame");
        let (_, frame) = module.types.iter().find(is_frame).expect("the shaders have a Frame");
        let naga::TypeInner::Struct { members, span } = &frame.inner else {
            panic!("Frame is no struct");
        };
        let found: Vec<(&str, usize)> =
            members.iter().map(|m| (m.name.as_deref().unwrap_or_default(), m.offset as usize)).collect();
        let expected = fields![
            size,
            material_frame_offset,
            punctual_offset,
            light_offset,
            instance_count,
            punctual_count,
            light_count,
            spp,
            max_bounces,
            strategy,
            frame_index,
            seed,
            sampling,
            jitter_px,
            pad_0,
            pad_1,
            pad_2,
            offset_floor,
            view_from_world,
            prev_view_from_world,
            projection,
            prev_projection,
            eye,
            sun_direction,
            sun_radiance,
            sky_zenith,
            sky_horizon,
            sky_ground,
            light_choice,
        ];
        assert_eq!(found, expected);
        assert_eq!(*span as usize, size_of::<FrameUniform>());
    }

    #[test]
    fn alias_table_keeps_the_weights() {
        let weights = [3.0, 0.0, 1.0, 0.5, 7.5];
        let mut chance = [0.0; 5];
        for (i, (keep, other)) in alias_table(&weights).into_iter().enumerate() {
            chance[i] += keep / 5.0;
            chance[other] += (1.0 - keep) / 5.0;
        }
        for (found, weight) in chance.iter().zip(weights) {
            assert!((found - weight / 12.0).abs() < 1e-6, "{chance:?}");
        }
    }
}
