//! Tiles, centres and buffer sizes of a render size; the Rust side of `shaders/include/features.wgsl`.

use crate::{CreateError, DenoiserDescriptor};

/// Features of a model, without the constant.
pub const FEATURES: u32 = 10;
/// Columns of a moment matrix: features and colour channels.
pub const COLUMNS: u32 = FEATURES + 3;
/// Entries of a moment matrix's upper triangle.
pub const SQUARES: u32 = COLUMNS * (COLUMNS + 1) / 2;
/// Entries in each of the two buffers that hold it.
pub const HALF_SQUARES: u32 = SQUARES.div_ceil(2);
/// Pixels on a side of a tile.
pub const TILE: u32 = 4;
/// Tiles between centres.
pub const CENTRE_STRIDE: u32 = 2;
/// Floats of a tile besides its squares.
pub const TILE_STRIDE: u32 = 4 + COLUMNS;
/// Floats of a model.
pub const MODEL_STRIDE: u32 = 4 + COLUMNS + 3 * FEATURES;

/// Workgroup memory that the largest pass needs.
pub const WORKGROUP_BYTES: u64 = 12 * 1024;

/// Tiles that cover `size` pixels.
pub fn tiles(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(TILE))
}

/// Model centres that cover `size` pixels.
pub fn centres(size: [u32; 2]) -> [u32; 2] {
    tiles(size).map(|side| side.div_ceil(CENTRE_STRIDE))
}

/// Sizes of the scratch buffers, in floats.
pub struct BufferSizes {
    /// Weights and means of tiles.
    pub tile_means: u64,
    /// One half of the tiles' squares.
    pub tile_squares_half: u64,
    /// Models.
    pub models: u64,
}

impl BufferSizes {
    /// Sizes for `size` pixels.
    pub fn of(size: [u32; 2]) -> Self {
        let count = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
        Self {
            tile_means: count(tiles(size)) * u64::from(TILE_STRIDE),
            tile_squares_half: count(tiles(size)) * u64::from(HALF_SQUARES),
            models: count(centres(size)) * u64::from(MODEL_STRIDE),
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
    let buffers = BufferSizes::of([width, height]);
    let largest = 4 * buffers.tile_means.max(buffers.tile_squares_half).max(buffers.models);
    let needs = [
        (
            "max_texture_dimension_2d",
            u64::from(width.max(height)),
            u64::from(limits.max_texture_dimension_2d),
        ),
        ("max_storage_buffer_binding_size", largest, limits.max_storage_buffer_binding_size),
        ("max_buffer_size", largest, limits.max_buffer_size),
        ("max_storage_buffers_per_shader_stage", 4, u64::from(limits.max_storage_buffers_per_shader_stage)),
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
