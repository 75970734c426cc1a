//! One frame's inputs and outputs, and their validation.

use crate::{FrameError, Settings};
use glam::{Mat4, Vec2};
use wgpu::{TextureFormat, TextureUsages};

/// The camera a frame was traced with. Matrices are for column vectors, unjittered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// World to view space: a rotation and a translation, no scale. View space is right-handed, looking down -z.
    pub view_from_world: Mat4,
    /// View to clip space, perspective or orthographic, without shear. NDC x points right, y up.
    pub clip_from_view: Mat4,
    /// Where this frame's samples lie relative to pixel centres, in pixels; +x right, +y down. 0 without jitter.
    pub jitter_px: Vec2,
}

/// Whether a frame continues the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HistoryMode {
    /// The frame follows the previous one; history is reprojected.
    #[default]
    Continue,
    /// A cut or a teleport: history is dropped and the frame is denoised on its own.
    Restart,
}

/// What a debug view shows. All are linear colours in 0 to 1 unless stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum DebugView {
    /// The models' prediction before it is mixed with the temporal mean (radiance, demodulated).
    Prediction = 1,
    /// The temporal mean that the models are fitted to (radiance, demodulated).
    TemporalMean = 2,
    /// Effective sample count over `max_history`: nearly black where history was just lost.
    HistoryLength = 3,
    /// Estimated standard error of the temporal mean over the mean.
    StandardError = 4,
    /// Weight of the temporal mean in the output: white trusts history, black the models.
    MixWeight = 5,
    /// World-space normal, mapped from -1..1 to 0..1.
    Normal = 6,
    /// View depth as `1 / (1 + depth)`.
    Depth = 7,
    /// Motion: hue is the direction, brightness the length (full at 16 pixels a frame).
    Motion = 8,
    /// A colour per surface id.
    SurfaceId = 9,
    /// Where models are and how large their windows: a bright dot per centre; windows of five tiles red, 3x3 green, 5x5 blue,
    /// mixed where models overlap.
    Windows = 10,
    /// How many models' windows hold the pixel; white at 16.
    Coverage = 11,
    /// Expected error of the output: the root of the mean squared error of its luminance.
    OutputError = 13,
    /// Predicted error of the models' prediction, before it is mixed with the temporal mean: the square root of the mean
    /// squared error of its luminance, demodulated.
    PredictedError = 12,
}

impl DebugView {
    /// Every view, in the order of its value.
    pub const ALL: [Self; 13] = [
        Self::Prediction,
        Self::TemporalMean,
        Self::HistoryLength,
        Self::StandardError,
        Self::MixWeight,
        Self::Normal,
        Self::Depth,
        Self::Motion,
        Self::SurfaceId,
        Self::Windows,
        Self::Coverage,
        Self::PredictedError,
        Self::OutputError,
    ];
}

/// Where a frame's passes write timestamps: pass `i` of [`PASSES`](crate::PASSES) begins at query
/// `first_query + 2 i` and ends at the one after it, also where it has nothing to do. The set needs
/// `Features::TIMESTAMP_QUERY`.
#[derive(Debug, Clone, Copy)]
pub struct Timestamps<'a> {
    /// A set of timestamp queries with at least `first_query + 2 * PASSES.len()` entries.
    pub query_set: &'a wgpu::QuerySet,
    /// Query that receives the begin of the first pass.
    pub first_query: u32,
}

/// Asks for the samples that each pixel should get in the next frame: where one more of them takes most off the expected
/// relative squared error of the output. The camera is taken to move on as it did; what comes into view, and what just did,
/// gets more at once. Trace that many paths per pixel and give the same image as [`FrameInputs::sample_count`].
#[derive(Debug, Clone, Copy)]
pub struct SampleMap<'a> {
    /// Receives the number of samples per pixel, 0 to four times the mean or to 2, rounded up; 1 at a miss, whose radiance is
    /// passed through. `R32Uint` with `STORAGE_BINDING`.
    pub view: &'a wgpu::TextureView,
    /// Mean samples per pixel, over what is no miss; 1/16 to 64. A quarter of them goes to all pixels alike.
    pub samples_per_pixel: f32,
    /// Luminance below which errors count absolutely, no longer relative to the pixel: what is about as dark in the picture
    /// that is shown. Above 0; 0.1 where scenes are exposed around 1.
    pub dark_level: f32,
}

/// The images of one frame. All have the denoiser's render size, mip level 0, one sample a pixel.
///
/// Invalid pixels need no care by the caller: NaN, infinite and negative radiance, zero albedo and zero normals
/// are repaired in `reproject`.
#[derive(Debug, Clone, Copy)]
pub struct FrameInputs<'a> {
    /// Noisy scene-linear radiance, direct emission included. `Rgba16Float` or `Rgba32Float`.
    pub radiance: &'a wgpu::TextureView,
    /// Diffuse reflectance at the first hit (specular colour at normal incidence for metals), linear once
    /// sampled; 1 at a miss. `Rgba8Unorm`, `Rgba8UnormSrgb` or `Rgba16Float`.
    pub albedo: &'a wgpu::TextureView,
    /// World-space unit shading normal in xyz, linear roughness 0 to 1 in w. `Rgba16Float` or `Rgba8Snorm`.
    pub normal_roughness: &'a wgpu::TextureView,
    /// Linear view-space depth, positive, in scene units; at or beyond `Settings::far` or 1e12, not positive or not finite
    /// is a miss. `R32Float`.
    pub depth: &'a wgpu::TextureView,
    /// Motion vector: `uv_prev = uv + motion.xy * Settings::motion_scale`, without jitter. With
    /// `Rgba16Float`, z is the previous view depth of the surface point minus the current one.
    /// `Rg16Float`, `Rg32Float` or `Rgba16Float`.
    pub motion: &'a wgpu::TextureView,
    /// Identity of object and material. History never crosses ids; in a prediction window the id is a feature, so that two
    /// surfaces get a level each. `R32Uint`.
    pub surface_id: Option<&'a wgpu::TextureView>,
    /// Radiance that the camera sees directly from emitters: taken out before filtering, added back after.
    /// `Rgba16Float`.
    pub emission: Option<&'a wgpu::TextureView>,
    /// Samples traced at each pixel this frame; 0 means that its radiance is ignored and predicted. Without
    /// this image every pixel has one. `R32Uint` or `R8Uint`.
    pub sample_count: Option<&'a wgpu::TextureView>,
    /// Radiance of this frame's samples that left the first hit through the specular lobe. Where it is given, `radiance` holds
    /// the rest, and the two are denoised apart: each with its own albedo, history and motion. Invalid pixels as in
    /// `radiance`; at a miss it is not looked at. History restarts where it comes or goes, and what it needs stays
    /// allocated. `Rgba16Float` or `Rgba32Float`.
    pub specular: Option<&'a wgpu::TextureView>,
    /// Reflectance of the specular lobe towards the camera, over all directions that light may come from, linear once sampled.
    /// Only with `specular`. Without this image it is derived from a reflectance at normal incidence of 0.04, roughness and
    /// view angle. `Rgba8Unorm`, `Rgba8UnormSrgb` or `Rgba16Float`.
    pub specular_albedo: Option<&'a wgpu::TextureView>,
    /// World-space distance from the first hit to what its specular ray hit; infinite, or at or beyond `Settings::far`, for the
    /// sky. 0, negative and NaN mean that it is not known, as where no specular ray was traced; neighbours then tell. With
    /// `specular`, its history follows what is seen in the surface; without, each tile's samples choose between that and
    /// the surface. `R32Float` or `R16Float`.
    pub hit_distance: Option<&'a wgpu::TextureView>,
    /// The camera of this frame. The previous one is remembered.
    pub camera: Camera,
    /// Whether history continues.
    pub history: HistoryMode,
    /// Receives the denoised radiance, scene-linear, alpha 1. `Rgba16Float` with `STORAGE_BINDING`.
    pub output: &'a wgpu::TextureView,
    /// Receives a debug view, where wanted. `Rgba16Float` with `STORAGE_BINDING`.
    pub debug: Option<(DebugView, &'a wgpu::TextureView)>,
    /// Receives the samples that the next frame should be traced with, where wanted.
    pub sample_map: Option<SampleMap<'a>>,
    /// Where to write timestamps, where wanted.
    pub timestamps: Option<Timestamps<'a>>,
    /// What the caller measured a frame of the denoiser to take on the GPU, in milliseconds, finite and not negative: the newest
    /// that is known, of one of the last three frames. Stands in for the denoiser's own timestamps in
    /// [`Budget::Milliseconds`](crate::Budget); needed on devices without them and on CPU adapters, whose timestamps do not
    /// wait for compute passes.
    pub measured_ms: Option<f32>,
}

/// What a frame was recorded with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameOutputs {
    /// Whether the frame started without history: by `HistoryMode::Restart`, because it is the first, or because `specular`
    /// came or went.
    pub restarted: bool,
    /// What the caller should know, once.
    pub notice: Option<Notice>,
}

/// What keeps a setting from working as it is meant to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Notice {
    /// A budget in milliseconds was set, but for eight frames nothing told how long they take: the number of models stays as it
    /// is. Said once in a denoiser's life.
    NoTimestamps,
}

const RADIANCE: &[TextureFormat] = &[TextureFormat::Rgba16Float, TextureFormat::Rgba32Float];
const ALBEDO: &[TextureFormat] =
    &[TextureFormat::Rgba8Unorm, TextureFormat::Rgba8UnormSrgb, TextureFormat::Rgba16Float];
const NORMAL: &[TextureFormat] = &[TextureFormat::Rgba16Float, TextureFormat::Rgba8Snorm];
const DEPTH: &[TextureFormat] = &[TextureFormat::R32Float];
const MOTION: &[TextureFormat] =
    &[TextureFormat::Rg16Float, TextureFormat::Rgba16Float, TextureFormat::Rg32Float];
const SURFACE_ID: &[TextureFormat] = &[TextureFormat::R32Uint];
const HIT_DISTANCE: &[TextureFormat] = &[TextureFormat::R32Float, TextureFormat::R16Float];
const HALF_RGBA: &[TextureFormat] = &[TextureFormat::Rgba16Float];
const SAMPLES: &[TextureFormat] = &[TextureFormat::R32Uint];
const SAMPLE_COUNT: &[TextureFormat] = &[TextureFormat::R32Uint, TextureFormat::R8Uint];

impl FrameInputs<'_> {
    /// Checks everything that can be checked without the GPU, before anything is recorded.
    pub(crate) fn check(&self, size: [u32; 2], settings: &Settings) -> Result<(), FrameError> {
        settings.check()?;
        self.camera.check()?;
        self.sample_map.map_or(Ok(()), |map| map.check())?;
        if let Some(found) = self.measured_ms.filter(|ms| !(ms.is_finite() && *ms >= 0.0)) {
            return Err(FrameError::MeasuredTime { found });
        }
        if self.specular_albedo.is_some() && self.specular.is_none() {
            return Err(FrameError::Missing { image: "specular", needed_by: "specular_albedo" });
        }
        let sampled = TextureUsages::TEXTURE_BINDING;
        let stored = TextureUsages::STORAGE_BINDING;
        let images = [
            ("radiance", Some(self.radiance), RADIANCE, sampled),
            ("albedo", Some(self.albedo), ALBEDO, sampled),
            ("normal_roughness", Some(self.normal_roughness), NORMAL, sampled),
            ("depth", Some(self.depth), DEPTH, sampled),
            ("motion", Some(self.motion), MOTION, sampled),
            ("surface_id", self.surface_id, SURFACE_ID, sampled),
            ("emission", self.emission, HALF_RGBA, sampled),
            ("sample_count", self.sample_count, SAMPLE_COUNT, sampled),
            ("specular", self.specular, RADIANCE, sampled),
            ("specular_albedo", self.specular_albedo, ALBEDO, sampled),
            ("hit_distance", self.hit_distance, HIT_DISTANCE, sampled),
            ("output", Some(self.output), HALF_RGBA, stored),
            ("debug", self.debug.map(|(_, view)| view), HALF_RGBA, stored),
            ("sample_map", self.sample_map.map(|map| map.view), SAMPLES, stored),
        ];
        let given = || images.iter().filter_map(|&(image, view, ..)| Some((image, view?)));
        for (image, view, formats, usage) in images {
            let Some(view) = view else { continue };
            check_image(image, view, formats, usage, size)?;
            let twin = given().find(|&(other, v)| other != image && v.texture() == view.texture());
            if let Some((other, _)) = twin.filter(|_| usage == stored) {
                return Err(FrameError::Aliased { image, other });
            }
        }
        Ok(())
    }
}

impl SampleMap<'_> {
    fn check(&self) -> Result<(), FrameError> {
        let refuse = |setting, expected, found: f32| {
            Err(FrameError::Setting { setting, expected, found: f64::from(found) })
        };
        if !(1.0 / 16.0..=64.0).contains(&self.samples_per_pixel) {
            return refuse("sample_map.samples_per_pixel", "1/16 to 64", self.samples_per_pixel);
        }
        if !(self.dark_level > 0.0 && self.dark_level.is_finite()) {
            return refuse("sample_map.dark_level", "a finite luminance above 0", self.dark_level);
        }
        Ok(())
    }
}

fn check_image(
    image: &'static str,
    view: &wgpu::TextureView,
    expected: &'static [TextureFormat],
    usage: TextureUsages,
    [width, height]: [u32; 2],
) -> Result<(), FrameError> {
    let texture = view.texture();
    let layers = texture.depth_or_array_layers();
    // A storage view has to be of one mip level; how many a view has cannot be asked.
    let mips = if usage == TextureUsages::STORAGE_BINDING { texture.mip_level_count() } else { 1 };
    if texture.dimension() != wgpu::TextureDimension::D2
        || layers != 1
        || mips != 1
        || texture.sample_count() != 1
    {
        return Err(FrameError::Shape {
            image,
            dimension: texture.dimension(),
            layers,
            mips,
            sample_count: texture.sample_count(),
        });
    }
    if (texture.width(), texture.height()) != (width, height) {
        return Err(FrameError::Size {
            image,
            width,
            height,
            found_width: texture.width(),
            found_height: texture.height(),
        });
    }
    if !expected.contains(&texture.format()) {
        return Err(FrameError::Format { image, expected, found: texture.format() });
    }
    if !texture.usage().contains(usage) {
        return Err(FrameError::Usage { image, expected: usage, found: texture.usage() });
    }
    Ok(())
}

impl Camera {
    fn check(&self) -> Result<(), FrameError> {
        let refuse = |field, reason| Err(FrameError::Camera { field, reason });
        let view = self.view_from_world;
        if !view.is_finite() {
            return refuse("view_from_world", "has an entry that is not finite");
        }
        if view.row(3) != glam::Vec4::W {
            return refuse("view_from_world", "has a last row other than 0 0 0 1 (is it transposed?)");
        }
        let rotation = glam::Mat3::from_mat4(view);
        if !(rotation * rotation.transpose()).abs_diff_eq(glam::Mat3::IDENTITY, 1e-2) {
            return refuse("view_from_world", "is not a rotation and a translation (has scale or shear)");
        }
        if rotation.determinant() < 0.0 {
            return refuse("view_from_world", "mirrors; expected a right-handed view space");
        }
        let p = self.clip_from_view;
        // An infinite far plane is fine; it never reaches x, y or w.
        let used =
            [p.x_axis.x, p.y_axis.y, p.z_axis.x, p.z_axis.y, p.z_axis.w, p.w_axis.x, p.w_axis.y, p.w_axis.w];
        if used.iter().any(|v| !v.is_finite()) {
            return refuse("clip_from_view", "has an entry that is not finite");
        }
        if p.x_axis.x == 0.0 || p.y_axis.y == 0.0 {
            return refuse("clip_from_view", "is singular (x or y scale is 0)");
        }
        if p.x_axis.y != 0.0 || p.x_axis.w != 0.0 || p.y_axis.x != 0.0 || p.y_axis.w != 0.0 {
            return refuse("clip_from_view", "has shear, expected a perspective or orthographic projection");
        }
        let (perspective, orthographic) = ((-1.0, 0.0), (0.0, 1.0));
        if ![perspective, orthographic].contains(&(p.z_axis.w, p.w_axis.w)) {
            return refuse("clip_from_view", "is neither perspective (w = -z) nor orthographic (w = 1)");
        }
        if !self.jitter_px.is_finite() {
            return refuse("jitter_px", "is not finite");
        }
        Ok(())
    }
}
