//! One frame's inputs: images, camera, and what is asked for.

use crate::gpu::flags;
use crate::{Camera, DebugView, HistoryMode, PassProfiler};
use wgpu::TextureView;

/// What every frame needs; everything else is added by [`FrameInputs`]' `with_` methods.
#[derive(Debug, Clone, Copy)]
pub struct RequiredInputs<'a> {
    /// See [`FrameInputs::radiance`].
    pub radiance: &'a TextureView,
    /// See [`FrameInputs::albedo`].
    pub albedo: &'a TextureView,
    /// See [`FrameInputs::normal_roughness`].
    pub normal_roughness: &'a TextureView,
    /// See [`FrameInputs::depth`].
    pub depth: &'a TextureView,
    /// See [`FrameInputs::motion`].
    pub motion: &'a TextureView,
    /// See [`FrameInputs::output`].
    pub output: &'a TextureView,
    /// See [`FrameInputs::camera`].
    pub camera: Camera,
}

/// The images of one frame and how it is to be denoised. All images have the denoiser's render size, or hold
/// [`viewport`](Self::viewport); mip level 0, one sample a pixel.
///
/// Invalid pixels need no care by the caller: NaN, infinite and negative radiance, zero albedo and zero normals
/// are repaired in `reproject`.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct FrameInputs<'a> {
    /// Noisy scene-linear radiance, direct emission included. `Rgba16Float`, `Rgba32Float` or `Rg11b10Ufloat`.
    pub radiance: &'a TextureView,
    /// Diffuse reflectance at the first hit (specular colour at normal incidence for metals), linear once
    /// sampled; 1 at a miss. `Rgba8Unorm`, `Rgba8UnormSrgb`, `Bgra8Unorm`, `Bgra8UnormSrgb`, `Rgb10a2Unorm` or `Rgba16Float`.
    pub albedo: &'a TextureView,
    /// Unit shading normal in xyz, or in xy as [`Conventions`](crate::Conventions) say; linear roughness 0 to 1 in w, 1 where the
    /// format has none. `Rgba16Float`, `Rgba32Float`, `Rgba8Snorm` or `Rgba16Snorm`; unsigned `Rgba8Unorm`, `Rgba16Unorm`, `Rgba16Float` or
    /// `Rgb10a2Unorm`; octahedral also `Rg16Float`, `Rg32Float`, `Rg8Snorm`, `Rg16Snorm`, unsigned `Rg8Unorm`, `Rg16Unorm`.
    pub normal_roughness: &'a TextureView,
    /// Depth, by default linear view-space depth, positive, in scene units; at or beyond `Settings::far` or 1e12, not positive or
    /// not finite is a miss, so clear to 0. `R32Float`; of a depth buffer also `Depth32Float`, `Depth24Plus`, `Depth16Unorm`
    /// or, by a view of the depth aspect alone, `Depth32FloatStencil8` or `Depth24PlusStencil8`.
    pub depth: &'a TextureView,
    /// Motion vector, by default `uv_prev = uv + motion.xy`, without jitter. With four channels, z is the previous view depth of
    /// the surface point minus the current one, unless
    /// [`Conventions::motion_has_depth`](crate::Conventions::motion_has_depth) is false.
    /// `Rg16Float`, `Rg32Float`, `Rgba16Float` or `Rgba32Float`.
    pub motion: &'a TextureView,
    /// Receives the denoised radiance, scene-linear, alpha 1. `Rgba16Float` with `STORAGE_BINDING`.
    pub output: &'a TextureView,
    /// The camera of this frame. The previous one is remembered.
    pub camera: Camera,
    /// Whether history continues (default).
    pub history: HistoryMode,
    /// The part of all images that is the frame. Default: all of them.
    pub viewport: Option<Viewport>,
    /// Linear roughness 0 to 1 in x, instead of that in `normal_roughness`. `R8Unorm`, `R16Float`, `R32Float`, or a format with
    /// more channels of these kinds.
    pub roughness: Option<&'a TextureView>,
    /// Identity of object and material. History never crosses ids; in a prediction window the id is a feature, so that two
    /// surfaces get a level each. `R32Uint` or `R16Uint`.
    pub surface_id: Option<&'a TextureView>,
    /// Radiance that the camera sees directly from emitters: taken out before filtering, added back after.
    /// As `radiance`.
    pub emission: Option<&'a TextureView>,
    /// Samples traced at each pixel this frame; 0 means that its radiance is ignored and predicted. Without
    /// this image every pixel has one. `R32Uint` or `R8Uint`.
    pub sample_count: Option<&'a TextureView>,
    /// Radiance of this frame's samples that left the first hit through the specular lobe. Where it is given, `radiance` holds
    /// the rest, and the two are denoised apart: each with its own albedo, history and motion. Invalid pixels as in
    /// `radiance`; at a miss it is not looked at. History restarts where it comes or goes, and what it needs stays
    /// allocated. As `radiance`.
    pub specular: Option<&'a TextureView>,
    /// Reflectance of the specular lobe towards the camera, over all directions that light may come from, linear once sampled.
    /// Only with `specular`. Without this image it is derived from a reflectance at normal incidence of 0.04, roughness and
    /// view angle. As `albedo`.
    pub specular_albedo: Option<&'a TextureView>,
    /// World-space distance from the first hit to what its specular ray hit; infinite, or at or beyond `Settings::far`, for the
    /// sky. 0, negative and NaN mean that it is not known, as where no specular ray was traced; neighbours then tell. With
    /// `specular`, its history follows what is seen in the surface; without, each tile's samples choose between that and
    /// the surface. `R32Float` or `R16Float`.
    pub hit_distance: Option<&'a TextureView>,
    /// Receives a debug view, where wanted. `Rgba16Float` with `STORAGE_BINDING`.
    pub debug: Option<(DebugView, &'a TextureView)>,
    /// Receives the samples that the next frame should be traced with, where wanted.
    pub sample_map: Option<SampleMap<'a>>,
    /// What times or marks the passes, where wanted.
    pub profiler: Option<&'a dyn PassProfiler>,
    /// What the caller measured a frame of the denoiser to take on the GPU, in milliseconds, finite and not negative: the newest
    /// that is known, of one of the last three frames. Stands in for the denoiser's own timestamps in
    /// [`Budget::Milliseconds`](crate::Budget); needed on devices without them and on CPU adapters, whose timestamps do not
    /// wait for compute passes.
    pub measured_ms: Option<f32>,
}

/// The part of the images that is the frame, in pixels, y down. Motion in UV, jitter and the camera are those of this part.
///
/// Its size may change in every frame, up to the denoiser's, as for dynamic resolution: history is kept, nothing is allocated.
/// Models that a [`Budget`](crate::Budget) kept are dropped then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Viewport {
    /// The top left pixel: x, y. The same in all images.
    pub origin: [u32; 2],
    /// Width and height; from 1x1 to the denoiser's render size.
    pub size: [u32; 2],
}

impl Viewport {
    /// The top left part.
    pub const fn of_size(width: u32, height: u32) -> Self {
        Self { origin: [0, 0], size: [width, height] }
    }
}

/// Asks for the samples that each pixel should get in the next frame: where one more of them takes most off the expected
/// relative squared error of the output. The camera is taken to move on as it did; what comes into view, and what just did,
/// gets more at once. Trace that many paths per pixel and give the image as [`FrameInputs::sample_count`]; the same one may be asked to
/// receive the next map.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct SampleMap<'a> {
    /// Receives the number of samples per pixel, 0 to four times the mean or to 2, rounded up; 1 at a miss, whose radiance is
    /// passed through. `R32Uint` with `STORAGE_BINDING`.
    pub view: &'a TextureView,
    /// Mean samples per pixel, over what is no miss; 1/16 to 64. A quarter of them goes to all pixels alike.
    pub samples_per_pixel: f32,
    /// Luminance below which errors count absolutely, no longer relative to the pixel: what is about as dark in the picture
    /// that is shown. Above 0; default 0.1, for scenes that are exposed around 1.
    pub dark_level: f32,
}

impl<'a> SampleMap<'a> {
    /// With the default [`dark_level`](Self::dark_level).
    pub fn new(view: &'a TextureView, samples_per_pixel: f32) -> Self {
        Self { view, samples_per_pixel, dark_level: 0.1 }
    }

    /// Sets [`dark_level`](Self::dark_level).
    pub fn with_dark_level(self, dark_level: f32) -> Self {
        Self { dark_level, ..self }
    }
}

impl<'a> FrameInputs<'a> {
    /// A frame with what it must have. It continues the one before.
    pub fn new(required: RequiredInputs<'a>) -> Self {
        let RequiredInputs { radiance, albedo, normal_roughness, depth, motion, output, camera } = required;
        Self {
            radiance,
            albedo,
            normal_roughness,
            depth,
            motion,
            output,
            camera,
            history: HistoryMode::Continue,
            viewport: None,
            roughness: None,
            surface_id: None,
            emission: None,
            sample_count: None,
            specular: None,
            specular_albedo: None,
            hit_distance: None,
            debug: None,
            sample_map: None,
            profiler: None,
            measured_ms: None,
        }
    }

    /// Tells the shaders which optional inputs came.
    pub(crate) fn flags(&self) -> u32 {
        let inputs = [
            (self.roughness.is_some(), flags::ROUGHNESS),
            (self.surface_id.is_some(), flags::SURFACE_ID),
            (self.emission.is_some(), flags::EMISSION),
            (self.sample_count.is_some(), flags::SAMPLE_COUNT),
            (self.specular.is_some(), flags::SPLIT),
            (self.specular_albedo.is_some(), flags::SPECULAR_ALBEDO),
            (self.hit_distance.is_some(), flags::HIT_DISTANCE),
        ];
        inputs.into_iter().filter_map(|(came, flag)| came.then_some(flag)).sum()
    }

    /// Sets [`history`](Self::history).
    pub fn with_history(self, history: HistoryMode) -> Self {
        Self { history, ..self }
    }

    /// Sets [`viewport`](Self::viewport). Takes a value or an `Option`, as those of other images below.
    pub fn with_viewport(self, viewport: impl Into<Option<Viewport>>) -> Self {
        Self { viewport: viewport.into(), ..self }
    }

    /// Sets [`roughness`](Self::roughness).
    pub fn with_roughness(self, roughness: impl Into<Option<&'a TextureView>>) -> Self {
        Self { roughness: roughness.into(), ..self }
    }

    /// Sets [`surface_id`](Self::surface_id).
    pub fn with_surface_id(self, surface_id: impl Into<Option<&'a TextureView>>) -> Self {
        Self { surface_id: surface_id.into(), ..self }
    }

    /// Sets [`emission`](Self::emission).
    pub fn with_emission(self, emission: impl Into<Option<&'a TextureView>>) -> Self {
        Self { emission: emission.into(), ..self }
    }

    /// Sets [`sample_count`](Self::sample_count).
    pub fn with_sample_count(self, sample_count: impl Into<Option<&'a TextureView>>) -> Self {
        Self { sample_count: sample_count.into(), ..self }
    }

    /// Sets [`specular`](Self::specular).
    pub fn with_specular(self, specular: impl Into<Option<&'a TextureView>>) -> Self {
        Self { specular: specular.into(), ..self }
    }

    /// Sets [`specular_albedo`](Self::specular_albedo).
    pub fn with_specular_albedo(self, specular_albedo: impl Into<Option<&'a TextureView>>) -> Self {
        Self { specular_albedo: specular_albedo.into(), ..self }
    }

    /// Sets [`hit_distance`](Self::hit_distance).
    pub fn with_hit_distance(self, hit_distance: impl Into<Option<&'a TextureView>>) -> Self {
        Self { hit_distance: hit_distance.into(), ..self }
    }

    /// Sets [`debug`](Self::debug).
    pub fn with_debug(self, debug: impl Into<Option<(DebugView, &'a TextureView)>>) -> Self {
        Self { debug: debug.into(), ..self }
    }

    /// Sets [`sample_map`](Self::sample_map).
    pub fn with_sample_map(self, sample_map: impl Into<Option<SampleMap<'a>>>) -> Self {
        Self { sample_map: sample_map.into(), ..self }
    }

    /// Sets [`profiler`](Self::profiler).
    pub fn with_profiler(self, profiler: &'a dyn PassProfiler) -> Self {
        Self { profiler: Some(profiler), ..self }
    }

    /// Sets [`measured_ms`](Self::measured_ms).
    pub fn with_measured_ms(self, measured_ms: impl Into<Option<f32>>) -> Self {
        Self { measured_ms: measured_ms.into(), ..self }
    }

    /// How many signals are denoised.
    pub(crate) fn signals(&self) -> u32 {
        if self.specular.is_some() { 2 } else { 1 }
    }
}
