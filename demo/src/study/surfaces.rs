//! What the pixels of the still image see, on the CPU, and the 4x4 tiles that errors are averaged over.

use crate::gbuffer::GBuffer;
use crate::gpu::Gpu;
use crate::image::{ImageRgb, luminance};
use anyhow::Result;

/// What the denoiser divides black by, and mixes every albedo with.
const COMBINED_FLOOR: f32 = 0.1;
/// Pixels on a side of the tiles that errors are averaged over: a quarter of the denoiser's.
pub const TILE: u32 = 4;

/// The first hits of the still image.
#[derive(Debug)]
pub struct Surfaces {
    pub width: u32,
    pub height: u32,
    /// False where the sky is seen.
    pub hit: Vec<bool>,
    pub id: Vec<u32>,
    pub albedo: ImageRgb,
    pub normal: ImageRgb,
    emission: ImageRgb,
}

impl Surfaces {
    /// Reads back what the tracer wrote. Waits for the GPU.
    pub fn read_back(gpu: &Gpu, gbuffer: &GBuffer) -> Result<Self> {
        let depth = gpu.read_texture(gbuffer.depth.texture())?;
        let depth: Vec<f32> = bytemuck::pod_collect_to_vec(&depth);
        let id = gpu.read_texture(gbuffer.surface_id.texture())?;
        Ok(Self {
            width: gbuffer.width,
            height: gbuffer.height,
            hit: depth.iter().map(|depth| depth.is_finite() && *depth > 0.0).collect(),
            id: bytemuck::pod_collect_to_vec(&id),
            albedo: ImageRgb::read_back(gpu, gbuffer.albedo.texture())?,
            normal: ImageRgb::read_back(gpu, gbuffer.normal_roughness.texture())?,
            emission: ImageRgb::read_back(gpu, gbuffer.emission.texture())?,
        })
    }

    /// Index of a pixel.
    pub fn index(&self, [x, y]: [u32; 2]) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// Luminance of what the models predict: radiance without emission, divided by albedo.
    pub fn demodulated_luminance(&self, radiance: &ImageRgb) -> Vec<f64> {
        let pixels = radiance.pixels.iter().zip(&self.emission.pixels).zip(&self.albedo.pixels);
        pixels
            .map(|((radiance, emission), albedo)| {
                luminance([0, 1, 2].map(|c| {
                    (radiance[c] - emission[c]) / (COMBINED_FLOOR + (1.0 - COMBINED_FLOOR) * albedo[c])
                }))
            })
            .collect()
    }
}

/// The tiles of the image that show surfaces.
#[derive(Debug)]
pub struct Tiles {
    /// Column and row of each.
    pub places: Vec<[u32; 2]>,
    /// The pixels of each that show a surface, by index.
    pixels: Vec<Vec<usize>>,
}

impl Tiles {
    /// All tiles that hold at least one pixel with a surface.
    pub fn new(surfaces: &Surfaces) -> Self {
        let [columns, rows] = [surfaces.width, surfaces.height].map(|side| side.div_ceil(TILE));
        let (mut places, mut pixels) = (Vec::new(), Vec::new());
        for place in (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row])) {
            let side = |axis: usize, end: u32| place[axis] * TILE..(place[axis] * TILE + TILE).min(end);
            let own: Vec<usize> = side(1, surfaces.height)
                .flat_map(|y| side(0, surfaces.width).map(move |x| [x, y]))
                .map(|pixel| surfaces.index(pixel))
                .filter(|&i| surfaces.hit[i])
                .collect();
            if !own.is_empty() {
                places.push(place);
                pixels.push(own);
            }
        }
        Self { places, pixels }
    }

    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// The mean of `value` over the pixels of each tile.
    pub fn means(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let mean = |pixels: &Vec<usize>| pixels.iter().map(|&i| value(i)).sum::<f64>() / pixels.len() as f64;
        self.pixels.iter().map(mean).collect()
    }

    /// Which tile holds a pixel; none where the tile sees no surface.
    pub fn holding(&self, [x, y]: [u32; 2]) -> Option<usize> {
        self.places.iter().position(|&place| place == [x / TILE, y / TILE])
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A white wall with the sky in the columns from `sky` on.
    pub fn wall(width: u32, height: u32, sky: u32) -> Surfaces {
        Surfaces {
            width,
            height,
            hit: (0..width * height).map(|i| i % width < sky).collect(),
            id: vec![1; (width * height) as usize],
            albedo: ImageRgb::from_fn(width, height, |_, _| [1.0; 3]),
            normal: ImageRgb::from_fn(width, height, |_, _| [0.0, 0.0, 1.0]),
            emission: ImageRgb::new(width, height),
        }
    }

    #[test]
    fn tiles_leave_the_sky_and_the_outside_out() {
        let surfaces = wall(11, 6, 6);
        let tiles = Tiles::new(&surfaces);
        assert_eq!(tiles.places, [[0, 0], [1, 0], [0, 1], [1, 1]], "the third column is all sky");
        assert_eq!(tiles.pixels.iter().map(Vec::len).collect::<Vec<_>>(), [16, 8, 8, 4]);
        let x_means = tiles.means(|i| (i % 11) as f64);
        assert_eq!(x_means, [1.5, 4.5, 1.5, 4.5]);
        assert_eq!((tiles.holding([5, 1]), tiles.holding([9, 1])), (Some(1), None));
    }

    #[test]
    fn emission_and_albedo_are_taken_out() {
        let mut surfaces = wall(2, 1, 2);
        surfaces.albedo.pixels[0] = [0.5; 3];
        surfaces.albedo.pixels[1] = [0.0; 3];
        surfaces.emission.pixels[0] = [1.0; 3];
        let demodulated = surfaces.demodulated_luminance(&ImageRgb::from_fn(2, 1, |_, _| [2.0; 3]));
        assert!((demodulated[0] - 1.0 / 0.55).abs() < 1e-5 && (demodulated[1] - 20.0).abs() < 1e-4);
    }
}
