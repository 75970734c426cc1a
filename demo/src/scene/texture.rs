//! Images of materials.

use glam::Vec2;

/// 8-bit RGBA, rows from the top. Colour textures hold sRGB, all others linear values; who samples it decides.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    pub name: String,
    pub width: u32,
    pub height: u32,
    pub rgba: Vec<u8>,
}

impl Image {
    /// An image of `size` by `size` texels from a function of the texel centre's uv.
    pub fn from_fn(name: &str, size: u32, texel: impl Fn(Vec2) -> [u8; 4]) -> Self {
        let at = |i: u32| (i as f32 + 0.5) / size as f32;
        let texels = (0..size * size).flat_map(|i| texel(Vec2::new(at(i % size), at(i / size))));
        Self { name: name.to_owned(), width: size, height: size, rgba: texels.collect() }
    }

    /// Tangent-space normals of a height field over uv that tiles; heights are in uv units.
    pub fn normals_from_height(name: &str, size: u32, height: impl Fn(Vec2) -> f32) -> Self {
        let step = 1.0 / size as f32;
        Self::from_fn(name, size, |uv| {
            let dx = height(uv + Vec2::X * step) - height(uv - Vec2::X * step);
            let dy = height(uv + Vec2::Y * step) - height(uv - Vec2::Y * step);
            // Image rows go down and glTF's v with them, but its green points up: hence +dy.
            let n = glam::Vec3::new(-dx, dy, 2.0 * step).normalize();
            let byte = |v: f32| ((v * 0.5 + 0.5) * 255.0).round() as u8;
            [byte(n.x), byte(n.y), byte(n.z), 255]
        })
    }
}

/// A use of an image: `uv' = rotation(scale * uv) + offset` as KHR_texture_transform defines it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureRef {
    pub image: usize,
    pub offset: Vec2,
    /// In radians, counter-clockwise as seen in an image whose v goes down.
    pub rotation: f32,
    pub scale: Vec2,
}

impl TextureRef {
    pub fn new(image: usize) -> Self {
        Self { image, offset: Vec2::ZERO, rotation: 0.0, scale: Vec2::ONE }
    }

    pub fn scaled(image: usize, scale: Vec2) -> Self {
        Self { scale, ..Self::new(image) }
    }

    /// Rows (x, y, offset) of the 2x3 matrix that moves uv.
    pub fn matrix(&self) -> [[f32; 3]; 2] {
        let (sin, cos) = self.rotation.sin_cos();
        [
            [cos * self.scale.x, sin * self.scale.y, self.offset.x],
            [-sin * self.scale.x, cos * self.scale.y, self.offset.y],
        ]
    }
}
