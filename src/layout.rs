//! Tiles, centres and buffer sizes of a render size; the Rust side of `shaders/include/features.wgsl`.

use crate::{CreateError, DenoiserDescriptor};

/// Features of the surface; what fits models adds some of its own.
pub const SURFACE_FEATURES: u32 = 9;
/// Pixels on a side of a tile, the unit of the windows of prediction.
pub const TILE: u32 = 4;
/// Pixels on a side of a region, the unit of the windows of the innovation.
pub const REGION: u32 = 8;
/// Levels of centres, coarse to fine.
pub const LEVELS: usize = 4;
/// Tiles between the centres of each level.
pub const LEVEL_STRIDES: [u32; LEVELS] = [8, 4, 2, 1];
/// Words of a level's indirect arguments and count.
pub const LEVEL_WORDS: u32 = 4;
/// Tiles on each side of the centre of the largest window.
pub const WIDEST_WINDOW: u32 = 3;
/// Coverage of a tile in the middle of one model.
pub const COVERAGE_ONE: u32 = 256;
/// What the sparse models are made of.
pub const MODELS: Columns = Columns { features: SURFACE_FEATURES + 2, head: 5 };
/// What the models of the innovation are made of.
pub const INNOVATIONS: Columns = Columns { features: SURFACE_FEATURES, head: 2 };

/// Sizes that follow from the number of features, in floats.
#[derive(Debug, Clone, Copy)]
pub struct Columns {
    /// Features of a model, without the constant.
    pub features: u32,
    /// Floats of a model before its means and slopes.
    pub head: u32,
}

impl Columns {
    /// Columns of a moment matrix: features and colour channels.
    pub const fn columns(self) -> u32 {
        self.features + 3
    }
    /// Entries of a moment matrix's upper triangle.
    pub const fn squares(self) -> u32 {
        self.columns() * (self.columns() + 1) / 2
    }
    /// Entries in each of the two buffers that hold it.
    pub const fn half_squares(self) -> u32 {
        self.squares().div_ceil(2)
    }
    /// Floats of a tile besides its squares.
    pub const fn tile_stride(self) -> u32 {
        4 + self.columns()
    }
    /// Floats of a model.
    pub const fn model_stride(self) -> u32 {
        self.head + self.columns() + 3 * self.features
    }
}

/// Workgroup memory that the largest pass needs.
pub const WORKGROUP_BYTES: u64 = 15 * 1024;

/// Tiles that cover `size` pixels.
pub fn tiles(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(TILE))
}

/// Regions that cover `size` pixels.
pub fn regions(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(REGION))
}

/// `[8, 4]` has 32.
pub fn count([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

/// Sizes of moments and models of a grid of tiles or regions, in floats.
#[derive(Debug, Clone, Copy)]
pub struct GridSizes {
    /// Weights, noises and means.
    pub means: u64,
    /// One half of the squares.
    pub half_squares: u64,
    /// Models, one per tile or region.
    pub models: u64,
}

impl GridSizes {
    /// Sizes for `count` tiles or regions.
    pub fn of(columns: Columns, count: u64) -> Self {
        Self {
            means: count * u64::from(columns.tile_stride()),
            half_squares: count * u64::from(columns.half_squares()),
            models: count * u64::from(columns.model_stride()),
        }
    }
}

/// Refuses what the device cannot hold, before anything is created on it.
pub(crate) fn check(device: &wgpu::Device, descriptor: &DenoiserDescriptor) -> Result<(), CreateError> {
    let &DenoiserDescriptor { width, height } = descriptor;
    if width == 0 || height == 0 {
        return Err(CreateError::EmptySize { width, height });
    }
    let limits = device.limits();
    // Of the innovation's regions there are fewer, with fewer columns.
    let tiles = GridSizes::of(MODELS, count(tiles([width, height])));
    let largest = 4 * tiles.means.max(tiles.half_squares).max(tiles.models);
    let needs = [
        (
            "max_texture_dimension_2d",
            u64::from(width.max(height)),
            u64::from(limits.max_texture_dimension_2d),
        ),
        ("max_storage_buffer_binding_size", largest, limits.max_storage_buffer_binding_size),
        ("max_buffer_size", largest, limits.max_buffer_size),
        ("max_storage_buffers_per_shader_stage", 8, u64::from(limits.max_storage_buffers_per_shader_stage)),
        ("max_storage_textures_per_shader_stage", 2, u64::from(limits.max_storage_textures_per_shader_stage)),
        ("max_sampled_textures_per_shader_stage", 7, u64::from(limits.max_sampled_textures_per_shader_stage)),
        (
            "max_compute_workgroup_storage_size",
            WORKGROUP_BYTES,
            u64::from(limits.max_compute_workgroup_storage_size),
        ),
        (
            "max_compute_invocations_per_workgroup",
            64,
            u64::from(limits.max_compute_invocations_per_workgroup),
        ),
    ];
    match needs.into_iter().find(|&(_, needed, available)| needed > available) {
        Some((limit, needed, available)) => {
            Err(CreateError::Limit { limit, needed, available, width, height })
        }
        None => Ok(()),
    }
}
