//! Textures that nobody uses at the moment, to be used again by whoever needs an equal one.

use wgpu::{TextureFormat, TextureUsages, TextureView};

/// What makes two textures equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    pub size: [u32; 2],
    pub format: TextureFormat,
    pub usage: TextureUsages,
}

impl Key {
    pub fn create(self, device: &wgpu::Device) -> TextureView {
        let [width, height] = self.size;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("transient"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: self.usage | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        texture.create_view(&Default::default())
    }
}

/// Frames that a texture waits before it is dropped; after a resize, those of the old size.
const PATIENCE: u32 = 2;

/// Counts since the last [`end_frame`](Pool::end_frame), and what is held.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    pub created: usize,
    pub recycled: usize,
    pub dropped: usize,
    pub held: usize,
}

/// Of textures, or in tests of anything.
#[derive(Debug)]
pub struct Pool<T> {
    /// With the number of frames that each was not used in.
    free: Vec<(Key, T, u32)>,
    counts: Counts,
}

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self { free: vec![], counts: Counts::default() }
    }
}

impl<T> Pool<T> {
    pub fn acquire(&mut self, key: Key, create: impl FnOnce() -> T) -> T {
        match self.free.iter().rposition(|(free, ..)| *free == key) {
            Some(i) => {
                self.counts.recycled += 1;
                self.free.swap_remove(i).1
            }
            None => {
                self.counts.created += 1;
                create()
            }
        }
    }

    pub fn release(&mut self, key: Key, texture: T) {
        self.free.push((key, texture, 0));
    }

    /// Drops what was not used for some frames.
    pub fn end_frame(&mut self) -> Counts {
        let before = self.free.len();
        self.free.retain_mut(|(_, _, unused)| {
            *unused += 1;
            *unused <= PATIENCE
        });
        let held = self.free.len();
        Counts { dropped: before - held, held, ..std::mem::take(&mut self.counts) }
    }
}
