//! Between the CPU's floats and textures.

use super::ImageRgb;
use crate::gpu::Gpu;
use anyhow::{Result, bail};
use half::f16;

/// `value` as a half float. Finite values beyond its range become its largest finite one, so that a bright light
/// does not turn into infinity; NaN and infinity stay what they are.
pub fn half_from_f32(value: f32) -> f16 {
    if value.is_finite() {
        f16::from_f32(value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()))
    } else {
        f16::from_f32(value)
    }
}

/// Writes all of mip level 0 of a 2D texture from tightly packed texels.
pub fn write_texture<T: bytemuck::Pod>(queue: &wgpu::Queue, texture: &wgpu::Texture, texels: &[T]) {
    let (width, height) = (texture.width(), texture.height());
    let bytes: &[u8] = bytemuck::cast_slice(texels);
    queue.write_texture(
        texture.as_image_copy(),
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some((bytes.len() / height as usize) as u32),
            rows_per_image: None,
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
}

impl ImageRgb {
    /// Reads a texture back, dropping alpha. `Rgba16Float` or `Rgba32Float` with `COPY_SRC`. Waits for the GPU.
    pub fn read_back(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Self> {
        let bytes = gpu.read_texture(texture)?;
        let pixels = match texture.format() {
            wgpu::TextureFormat::Rgba16Float => bytes
                .chunks_exact(8)
                .map(|texel| [0, 2, 4].map(|i| f16::from_le_bytes([texel[i], texel[i + 1]]).to_f32()))
                .collect(),
            wgpu::TextureFormat::Rgba32Float => bytes
                .chunks_exact(16)
                .map(|texel| {
                    [0, 4, 8]
                        .map(|i| f32::from_le_bytes([texel[i], texel[i + 1], texel[i + 2], texel[i + 3]]))
                })
                .collect(),
            format => bail!("cannot read {format:?} as an RGB image; Rgba16Float and Rgba32Float work"),
        };
        Ok(Self { width: texture.width(), height: texture.height(), pixels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bright_values_stay_finite_in_half() {
        assert_eq!(half_from_f32(1e9), f16::MAX);
        assert_eq!(half_from_f32(-1e9), f16::MIN);
        assert_eq!(half_from_f32(f32::INFINITY), f16::INFINITY);
        assert!(half_from_f32(f32::NAN).is_nan());
    }

    #[test]
    fn a_texture_comes_back_as_it_was_written() {
        let gpu = Gpu::new().expect("tests need a Vulkan driver");
        let gbuffer = crate::gbuffer::GBuffer::new(&gpu.device, 5, 3);
        let image = ImageRgb::from_fn(5, 3, |x, y| [x as f32 * 0.25, y as f32, -2.0]);
        let wide: Vec<[f32; 4]> = image.pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        write_texture(&gpu.queue, gbuffer.radiance.texture(), &wide);
        assert_eq!(ImageRgb::read_back(&gpu, gbuffer.radiance.texture()).unwrap(), image);
        let half: Vec<[f16; 4]> = wide.iter().map(|texel| texel.map(half_from_f32)).collect();
        write_texture(&gpu.queue, gbuffer.albedo.texture(), &half);
        assert_eq!(ImageRgb::read_back(&gpu, gbuffer.albedo.texture()).unwrap(), image);
        assert!(ImageRgb::read_back(&gpu, gbuffer.depth.texture()).is_err());
    }
}
