//! Material images as one texture array of a common size, with mip levels.

use crate::gpu::Gpu;
use crate::scene::{Image, Scene};
use anyhow::{Context, Result, ensure};

/// The same texels twice: decoded from sRGB, and as they are.
#[derive(Debug)]
pub(super) struct ImageArray {
    pub color: wgpu::TextureView,
    pub data: wgpu::TextureView,
}

/// More images than this are kept at half the size, to bound the memory.
const MANY_IMAGES: usize = 64;

impl ImageArray {
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self> {
        let limit = gpu.device.limits().max_texture_array_layers as usize;
        let count = scene.images.len();
        ensure!(count <= limit, "the scene has {count} images, at most {limit} can be used");
        let largest = scene.images.iter().map(|i| i.width.max(i.height)).max().unwrap_or(1);
        let size = largest.next_power_of_two().min(if count > MANY_IMAGES { 512 } else { 1024 });
        let levels = size.ilog2() + 1;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("scene images"),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: count.max(1) as u32 },
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[wgpu::TextureFormat::Rgba8UnormSrgb],
        });
        let is_color = color_images(scene);
        for (layer, image) in scene.images.iter().enumerate() {
            let mut texels = resized(image, size)
                .with_context(|| format!("image {layer} ({}) does not match its size", image.name))?;
            for level in 0..levels {
                let width = size >> level;
                write_level(gpu, &texture, layer as u32, level, width, &texels);
                if width > 1 {
                    texels = halved(&texels, width, is_color[layer]);
                }
            }
        }
        let view = |format| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                format: Some(format),
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            })
        };
        Ok(Self {
            color: view(wgpu::TextureFormat::Rgba8UnormSrgb),
            data: view(wgpu::TextureFormat::Rgba8Unorm),
        })
    }
}

fn color_images(scene: &Scene) -> Vec<bool> {
    let mut is_color = vec![false; scene.images.len()];
    for material in &scene.materials {
        for texture in [material.base_color_texture, material.emissive_texture].into_iter().flatten() {
            is_color[texture.image] = true;
        }
    }
    is_color
}

fn write_level(gpu: &Gpu, texture: &wgpu::Texture, layer: u32, level: u32, width: u32, texels: &[u8]) {
    let target = wgpu::TexelCopyTextureInfo {
        texture,
        mip_level: level,
        origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
        aspect: wgpu::TextureAspect::All,
    };
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: None };
    let extent = wgpu::Extent3d { width, height: width, depth_or_array_layers: 1 };
    gpu.queue.write_texture(target, texels, layout, extent);
}

fn resized(image: &Image, size: u32) -> Option<Vec<u8>> {
    if (image.width, image.height) == (size, size) {
        return (image.rgba.len() == 4 * (size * size) as usize).then(|| image.rgba.clone());
    }
    let source = image::RgbaImage::from_raw(image.width, image.height, image.rgba.clone())?;
    Some(image::imageops::resize(&source, size, size, image::imageops::FilterType::Triangle).into_raw())
}

/// The next mip level: means of 2x2 texels, of light for colour images.
fn halved(texels: &[u8], width: u32, is_color: bool) -> Vec<u8> {
    let decode: Vec<f32> = (0..=255u8)
        .map(|b| {
            let v = f32::from(b) / 255.0;
            if !is_color {
                v
            } else if v <= 0.04045 {
                v / 12.92
            } else {
                ((v + 0.055) / 1.055).powf(2.4)
            }
        })
        .collect();
    let encode = |v: f32| {
        let v = if !is_color {
            v
        } else if v <= 0.003_130_8 {
            12.92 * v
        } else {
            1.055 * v.powf(1.0 / 2.4) - 0.055
        };
        (v * 255.0).round() as u8
    };
    let width = width as usize;
    let half = width / 2;
    let mut out = Vec::with_capacity(4 * half * half);
    for y in 0..half {
        for x in 0..half {
            let at = |dx: usize, dy: usize, c: usize| texels[4 * ((2 * y + dy) * width + 2 * x + dx) + c];
            for c in 0..4 {
                let four = [at(0, 0, c), at(1, 0, c), at(0, 1, c), at(1, 1, c)];
                out.push(if c < 3 {
                    encode(four.iter().map(|&b| decode[usize::from(b)]).sum::<f32>() / 4.0)
                } else {
                    (four.iter().map(|&b| u32::from(b)).sum::<u32>() / 4) as u8
                });
            }
        }
    }
    out
}
