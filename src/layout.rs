//! Tiles, centres and buffer sizes of a render size; the Rust side of `shaders/include/features.wgsl`.

use crate::{CreateError, DenoiserDescriptor};

/// Features of the surface; what fits models adds some of its own.
pub const SURFACE_FEATURES: u32 = 9;
/// Pixels on a side of a tile, the unit of windows.
pub const TILE: u32 = 8;
/// Levels of centres, coarse to fine.
pub const LEVELS: usize = 3;
/// Tiles between the centres of each level.
pub const LEVEL_STRIDES: [u32; LEVELS] = [4, 2, 1];
/// Words of a level's indirect arguments and count.
pub const LEVEL_WORDS: u32 = 4;
/// Tiles of each window, by window from 1; 0 is none.
pub const WINDOW_TILES: [u32; 4] = [0, 5, 9, 25];
/// Pixels that the widest window spans.
pub const WIDEST_WINDOW_PX: u32 = 40;
/// Words of all levels, then of what they share: the number of models that were kept.
pub const LEVELS_WORDS: u32 = LEVEL_WORDS * LEVELS as u32 + 1;
/// Buckets of each level's histogram of gains.
pub const BUCKETS: u32 = 1024;
/// Coverage of a tile in the middle of one model.
pub const COVERAGE_ONE: u32 = 256;
/// Of the histogram of what samples are worth.
pub const SAMPLE_BUCKETS: u64 = 512;
/// What the moments of the sparse models are made of.
pub const MODELS: Columns = Columns { features: SURFACE_FEATURES + 2 };
/// What the moments of the innovation are made of.
pub const INNOVATIONS: Columns = Columns { features: SURFACE_FEATURES };
/// Tiles from one centre of the innovation to the next; twice as many where moments are sparse.
pub const INNOVATION_TILES: u32 = 2;
/// Floats of a model of either kind: a head of 4, then 3 rows of 12.
pub const MODEL_STRIDE: u32 = 40;

/// Sizes that follow from the number of features, in floats.
#[derive(Debug, Clone, Copy)]
pub struct Columns {
    /// Features of a model, without the constant.
    pub features: u32,
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
    /// Floats of a tile: its head, means and squares, in whole groups of four.
    pub const fn tile_stride(self) -> u32 {
        4 + self.columns().next_multiple_of(4) + self.squares().next_multiple_of(4)
    }
}

/// Workgroup memory that the largest pass needs.
pub const WORKGROUP_BYTES: u64 = 8_208;

/// Tiles that cover `size` pixels.
pub fn tiles(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(TILE))
}

/// Models of the coarsest level, which are fitted under any budget.
pub fn least_models(size: [u32; 2]) -> u64 {
    count(tiles(size).map(|side| side.div_ceil(LEVEL_STRIDES[0])))
}

/// Centres of the innovation in a frame of `size` pixels.
pub fn innovation_centres(size: [u32; 2], is_sparse: bool) -> [u32; 2] {
    let step = if is_sparse { 2 * INNOVATION_TILES } else { INNOVATION_TILES };
    tiles(size).map(|side| side.div_ceil(step))
}

/// `[8, 4]` has 32.
pub fn count([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

/// Floats of the moments of `tiles`: first those of the change of the light, then those of the temporal means.
pub fn moments(tiles: u64) -> u64 {
    tiles * u64::from(MODELS.tile_stride())
}

/// Floats of as many models, of either kind.
pub fn models(count: u64) -> u64 {
    count * u64::from(MODEL_STRIDE)
}

/// What depends on the render size.
pub(crate) struct Needs {
    /// The longer side, in pixels.
    pub side: u32,
    /// Bytes of the largest buffer.
    pub buffer: u64,
}

impl Needs {
    pub fn new(&DenoiserDescriptor { width, height }: &DenoiserDescriptor) -> Self {
        let tiles = count(tiles([width, height]));
        Self { side: width.max(height), buffer: 4 * moments(tiles).max(models(tiles)) }
    }
}

/// Refuses what the device cannot hold, before anything is created on it.
pub(crate) fn check(device: &wgpu::Device, descriptor: &DenoiserDescriptor) -> Result<(), CreateError> {
    let &DenoiserDescriptor { width, height } = descriptor;
    if width == 0 || height == 0 {
        return Err(CreateError::EmptySize { width, height });
    }
    let limits = device.limits();
    let Needs { side, buffer } = Needs::new(descriptor);
    // Name, what is needed, what there is.
    let needs: [(&str, u64, u64); 8] = [
        ("max_texture_dimension_2d", side.into(), limits.max_texture_dimension_2d.into()),
        ("max_storage_buffer_binding_size", buffer, limits.max_storage_buffer_binding_size),
        ("max_buffer_size", buffer, limits.max_buffer_size),
        ("max_storage_buffers_per_shader_stage", 6, limits.max_storage_buffers_per_shader_stage.into()),
        ("max_storage_textures_per_shader_stage", 4, limits.max_storage_textures_per_shader_stage.into()),
        ("max_sampled_textures_per_shader_stage", 13, limits.max_sampled_textures_per_shader_stage.into()),
        (
            "max_compute_workgroup_storage_size",
            WORKGROUP_BYTES,
            limits.max_compute_workgroup_storage_size.into(),
        ),
        ("max_compute_invocations_per_workgroup", 256, limits.max_compute_invocations_per_workgroup.into()),
    ];
    match needs.into_iter().find(|&(_, needed, available)| needed > available) {
        Some((limit, needed, available)) => {
            Err(CreateError::Limit { limit, needed, available, width, height })
        }
        None => Ok(()),
    }
}
