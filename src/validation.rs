//! What can be checked of a frame without the GPU, before anything is recorded.

use crate::{DepthEncoding, FrameError, FrameInputs, NormalEncoding, SampleMap, Settings, Viewport};
use wgpu::{TextureFormat, TextureUsages};

use TextureFormat as F;

const RADIANCE: &[F] = &[F::Rgba16Float, F::Rgba32Float, F::Rg11b10Ufloat];
const ALBEDO: &[F] =
    &[F::Rgba8Unorm, F::Rgba8UnormSrgb, F::Bgra8Unorm, F::Bgra8UnormSrgb, F::Rgb10a2Unorm, F::Rgba16Float];
const DEPTH: &[F] = &[F::R32Float];
const DEPTH_BUFFER: &[F] = &[
    F::Depth32Float,
    F::Depth24Plus,
    F::Depth16Unorm,
    F::Depth32FloatStencil8,
    F::Depth24PlusStencil8,
    F::R32Float,
];
const MOTION: &[F] = &[F::Rg16Float, F::Rg32Float, F::Rgba16Float, F::Rgba32Float];
const ROUGHNESS: &[F] =
    &[F::R8Unorm, F::R16Float, F::R32Float, F::Rg8Unorm, F::Rg16Float, F::Rgba8Unorm, F::Rgba16Float];
const SURFACE_ID: &[F] = &[F::R32Uint, F::R16Uint];
const HIT_DISTANCE: &[F] = &[F::R32Float, F::R16Float];
const OUTPUT: &[F] = &[F::Rgba16Float];
const SAMPLES: &[F] = &[F::R32Uint];
const SAMPLE_COUNT: &[F] = &[F::R32Uint, F::R8Uint];

fn normal_formats(encoding: NormalEncoding) -> &'static [F] {
    match encoding {
        NormalEncoding::Signed => &[F::Rgba16Float, F::Rgba8Snorm, F::Rgba32Float, F::Rgba16Snorm],
        NormalEncoding::Unsigned => &[F::Rgba8Unorm, F::Rgb10a2Unorm, F::Rgba16Float, F::Rgba16Unorm],
        NormalEncoding::Octahedral => &[
            F::Rg16Float,
            F::Rg32Float,
            F::Rg8Snorm,
            F::Rg16Snorm,
            F::Rgba16Float,
            F::Rgba8Snorm,
            F::Rgba16Snorm,
        ],
        NormalEncoding::OctahedralUnsigned => &[
            F::Rg8Unorm,
            F::Rg16Unorm,
            F::Rg16Float,
            F::Rgba8Unorm,
            F::Rgb10a2Unorm,
            F::Rgba16Float,
            F::Rgba16Unorm,
        ],
    }
}

impl FrameInputs<'_> {
    /// Checks everything that can be checked without the GPU, before anything is recorded.
    pub(crate) fn check(&self, largest: [u32; 2], settings: &Settings) -> Result<Viewport, FrameError> {
        settings.check()?;
        self.camera.check(&settings.conventions)?;
        let frame = self.part(largest)?;
        self.sample_map.map_or(Ok(()), |map| map.check())?;
        if let Some(found) = self.measured_ms.filter(|ms| !(ms.is_finite() && *ms >= 0.0)) {
            return Err(FrameError::MeasuredTime { found });
        }
        if self.specular_albedo.is_some() && self.specular.is_none() {
            return Err(FrameError::Missing { image: "specular", needed_by: "specular_albedo" });
        }
        let conventions = &settings.conventions;
        let depth = if conventions.depth == DepthEncoding::Hardware { DEPTH_BUFFER } else { DEPTH };
        let sampled = TextureUsages::TEXTURE_BINDING;
        let stored = TextureUsages::STORAGE_BINDING;
        let images = [
            ("radiance", Some(self.radiance), RADIANCE, sampled),
            ("albedo", Some(self.albedo), ALBEDO, sampled),
            (
                "normal_roughness",
                Some(self.normal_roughness),
                normal_formats(conventions.normal_encoding),
                sampled,
            ),
            ("depth", Some(self.depth), depth, sampled),
            ("motion", Some(self.motion), MOTION, sampled),
            ("roughness", self.roughness, ROUGHNESS, sampled),
            ("surface_id", self.surface_id, SURFACE_ID, sampled),
            ("emission", self.emission, RADIANCE, sampled),
            ("sample_count", self.sample_count, SAMPLE_COUNT, sampled),
            ("specular", self.specular, RADIANCE, sampled),
            ("specular_albedo", self.specular_albedo, ALBEDO, sampled),
            ("hit_distance", self.hit_distance, HIT_DISTANCE, sampled),
            ("output", Some(self.output), OUTPUT, stored),
            ("debug", self.debug.map(|(_, view)| view), OUTPUT, stored),
            ("sample_map", self.sample_map.map(|map| map.view), SAMPLES, stored),
        ];
        let given = || images.iter().filter_map(|&(image, view, ..)| Some((image, view?)));
        for (image, view, formats, usage) in images {
            let Some(view) = view else { continue };
            check_image(image, view, formats, usage, frame)?;
            // Where samples went is read before it is asked where they should go.
            let is_in_turn = |other| image == "sample_map" && other == "sample_count";
            let is_twin = |other, v: &wgpu::TextureView| {
                other != image && !is_in_turn(other) && v.texture() == view.texture()
            };
            let twin = given().find(|&(other, v)| is_twin(other, v));
            if let Some((other, _)) = twin.filter(|_| usage == stored) {
                return Err(FrameError::Aliased { image, other });
            }
        }
        Ok(frame.viewport)
    }

    /// What the frame is of images that hold it.
    fn part(&self, largest: [u32; 2]) -> Result<Part, FrameError> {
        let Some(viewport) = self.viewport else {
            return Ok(Part { viewport: Viewport { origin: [0, 0], size: largest }, is_all: true });
        };
        let fits = (0..2).all(|axis| (1..=largest[axis]).contains(&viewport.size[axis]));
        if !fits || (0..2).any(|axis| viewport.origin[axis].checked_add(viewport.size[axis]).is_none()) {
            return Err(FrameError::Viewport { viewport, largest });
        }
        Ok(Part { viewport, is_all: false })
    }
}

/// Where the frame lies in its images.
#[derive(Clone, Copy)]
struct Part {
    viewport: Viewport,
    /// Whether the images are no larger.
    is_all: bool,
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
    expected: &'static [F],
    usage: TextureUsages,
    frame: Part,
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
    let Viewport { origin, size } = frame.viewport;
    let found = [texture.width(), texture.height()];
    let holds = if frame.is_all {
        found == size
    } else {
        (0..2).all(|axis| origin[axis] + size[axis] <= found[axis])
    };
    if !holds {
        return Err(match frame.is_all {
            true => FrameError::Size {
                image,
                width: size[0],
                height: size[1],
                found_width: found[0],
                found_height: found[1],
            },
            false => FrameError::Outside {
                image,
                viewport: frame.viewport,
                found_width: found[0],
                found_height: found[1],
            },
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
