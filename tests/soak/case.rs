//! A combination of switches, and frames with it.

use crate::pool::{Pool, SIZE};
use glam::{Mat4, Quat, Vec2, Vec3, camera::rh::proj::directx};
use quell::{
    Budget, Camera, Centres, Conventions, DebugView, DepthEncoding, FrameInputs, Handedness, HistoryMode,
    MotionDirection, MotionUnit, NormalEncoding, NormalSpace, RequiredInputs, SampleMap, Settings, Viewport,
    Windows,
};
use rand::{Rng, rngs::StdRng, seq::IndexedRandom};

/// What stays for some frames.
#[derive(Debug)]
pub struct Case {
    conventions: Conventions,
    has_id: bool,
    has_emission: bool,
    has_count: bool,
    has_roughness: bool,
    has_hit_distance: bool,
    has_specular: bool,
    has_specular_albedo: bool,
    shown: Option<DebugView>,
    has_map: bool,
    innovation: bool,
    mix: bool,
    windows: Windows,
    centres: Centres,
    budget: Budget,
}

fn one_of<T: Copy>(random: &mut StdRng, list: &[T]) -> T {
    *list.choose(random).unwrap()
}

impl Case {
    pub fn new(random: &mut StdRng) -> Self {
        let mut chance = || random.random_bool(0.4);
        let [has_id, has_emission, has_count, has_roughness, has_hit_distance, has_specular] =
            std::array::from_fn(|_| chance());
        let has_specular_albedo = has_specular && chance();
        let (innovation, mix, has_map, is_shown) = (!chance(), !chance(), chance(), chance());
        Self {
            conventions: conventions(random),
            has_id,
            has_emission,
            has_count,
            has_roughness,
            has_hit_distance,
            has_specular,
            has_specular_albedo,
            shown: is_shown.then(|| one_of(random, &DebugView::ALL)),
            has_map,
            innovation,
            mix,
            windows: one_of(random, &[Windows::MallowsCp, Windows::RingError, Windows::Fixed(3)]),
            centres: one_of(random, &[Centres::Adaptive, Centres::Adaptive, Centres::Uniform(2)]),
            budget: one_of(
                random,
                &[
                    Budget::Unlimited,
                    Budget::Models(0),
                    Budget::Models(30),
                    Budget::Models(u32::MAX),
                    Budget::Milliseconds(0.1),
                ],
            ),
        }
    }

    /// A frame of any content, size and camera, with these switches.
    pub fn frame<'a>(
        &self,
        random: &mut StdRng,
        pool: &'a Pool,
        output: &'a wgpu::TextureView,
        largest: [u32; 2],
    ) -> (FrameInputs<'a>, Settings) {
        // Mostly sane ones, or nothing sane would ever be denoised.
        fn some<'a>(random: &mut StdRng, list: &'a [wgpu::TextureView]) -> &'a wgpu::TextureView {
            &list[if random.random_bool(0.6) { 0 } else { random.random_range(0..list.len()) }]
        }
        let size =
            largest.map(|side| if random.random_bool(0.5) { side } else { random.random_range(1..=side) });
        let origin = [0, 1].map(|axis| random.random_range(0..=SIZE[axis] - size[axis]));
        let inputs = FrameInputs::new(RequiredInputs {
            radiance: some(random, &pool.colours),
            albedo: some(random, &pool.colours),
            normal_roughness: some(random, &pool.normals),
            depth: some(random, &pool.scalars),
            motion: some(random, &pool.motions),
            output,
            camera: camera(random, &self.conventions),
        })
        .with_history(if random.random_bool(0.05) { HistoryMode::Restart } else { HistoryMode::Continue })
        .with_viewport(Viewport { origin, size })
        .with_surface_id(self.has_id.then(|| some(random, &pool.ids)))
        .with_emission(self.has_emission.then(|| some(random, &pool.colours)))
        .with_sample_count(self.has_count.then(|| some(random, &pool.counts)))
        .with_roughness(self.has_roughness.then(|| some(random, &pool.scalars)))
        .with_hit_distance(self.has_hit_distance.then(|| some(random, &pool.scalars)))
        .with_specular(self.has_specular.then(|| some(random, &pool.colours)))
        .with_specular_albedo(self.has_specular_albedo.then(|| some(random, &pool.colours)))
        .with_debug(self.shown.map(|view| (view, &pool.shown)))
        .with_sample_map(self.has_map.then(|| SampleMap::new(&pool.map, random.random_range(0.0625..64.0))))
        .with_measured_ms(random.random_bool(0.5).then(|| random.random_range(0.0..20.0)));
        let settings = Settings::default()
            .with_conventions(self.conventions)
            .with_innovation(self.innovation)
            .with_mix_temporal_mean(self.mix)
            .with_windows(self.windows)
            .with_centres(self.centres)
            .with_budget(self.budget)
            .with_savings(one_of(random, &[0, 0, 1, 2]))
            .with_most_savings(one_of(random, &[0, 2]))
            .with_far(one_of(random, &[f32::INFINITY, f32::INFINITY, 3.0, 1e-30, f32::MAX]))
            .with_max_history(one_of(random, &[1.0, 8.0, 32.0, 32.0, 1024.0]))
            .with_firefly_limit(one_of(random, &[1.0, 1.0, 1e-20, f32::MAX, f32::INFINITY]));
        (inputs, settings)
    }
}

fn conventions(random: &mut StdRng) -> Conventions {
    use DepthEncoding::{Distance, Hardware, Linear};
    use NormalEncoding::{Octahedral, Signed, Unsigned};
    // Those of float formats, which the pool has.
    let encodings = [Signed, Unsigned, Octahedral, NormalEncoding::OctahedralUnsigned];
    let scale = [random.random_range(-1e9..1e9), 0.0];
    Conventions::default()
        .with_depth(one_of(random, &[Linear, Linear, Distance, Hardware]))
        .with_motion_unit(one_of(
            random,
            &[MotionUnit::Uv, MotionUnit::Pixels, MotionUnit::Ndc, MotionUnit::Scaled(scale)],
        ))
        .with_motion_direction(one_of(random, &[MotionDirection::ToPrevious, MotionDirection::FromPrevious]))
        .with_motion_is_jittered(random.random())
        .with_motion_has_depth(random.random())
        .with_normal_encoding(one_of(random, &encodings))
        .with_normal_space(one_of(random, &[NormalSpace::World, NormalSpace::View]))
        .with_handedness(one_of(random, &[Handedness::Right, Handedness::Left]))
}

fn camera(random: &mut StdRng, conventions: &Conventions) -> Camera {
    let aspect = random.random_range(0.01..100.0);
    let projections = [
        directx::perspective(random.random_range(0.001..3.1), aspect, 1e-3, 1e6),
        directx::perspective_infinite_reverse(1.0, aspect, 0.1),
        directx::perspective_infinite_reverse(1.0, 1.5, 0.1),
        directx::orthographic(-2.0, 3.0 * aspect, -1.0, 1.0, 0.1, 100.0),
    ];
    let distance = one_of(random, &[0.0, 1.0, 1.0, 1e3, 1e8, 1e20, f32::MAX]);
    let step = Vec3::new(random.random(), random.random(), random.random());
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.02 * step.x, random.random_range(-3.0..3.0), 0.0);
    let flip = match conventions.handedness {
        Handedness::Right => Mat4::IDENTITY,
        Handedness::Left => Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0)),
    };
    let jitter = one_of(random, &[0.0, 0.5, 0.5, 1e6]);
    Camera::new(Mat4::from_rotation_translation(turn, step * distance), one_of(random, &projections) * flip)
        .with_jitter(Vec2::new(jitter, -jitter))
}
