// centres: lists the centres of one level that no model of a coarser level covers well. `fit` then runs on the list.
// Under a budget it lists the coarsest level alone, whose models are to reach all tiles; `choose` lists the others.
//
// Reads   coverage, moments.
// Writes  centre_list: their tiles; levels: how many, as arguments of an indirect dispatch (layout: include/models)
// Source  Moon et al. 2015, section 4.3: a centre is placed where no prediction reaches yet

//!include frame numbers surface features windows models listing

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> level: vec4<u32>; // its number in x
@group(0) @binding(2) var<storage, read> coverage: array<u32>;
@group(0) @binding(3) var<storage, read> moments: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> centre_list: array<u32>;
@group(0) @binding(5) var<storage, read_write> levels: array<atomic<u32>>;

const OWN_FEATURES = MODEL_OWN_FEATURES;

@compute @workgroup_size(8, 8)
fn centres(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    // The middle of each cell of the level's grid, so that the finest level is every tile.
    let own = frame.levels[level.x];
    var tile = id.xy * own.stride + own.stride / 2u;
    if has(frame, FLAG_LIMITED) && all(id.xy * own.stride < frame.tiles) {
        tile = coarsest_centre(frame, tile);
    }
    let index = tile.y * frame.tiles.x + tile.x;
    var wanted = all(tile < frame.tiles);
    if wanted {
        wanted = coverage[index] < own.covered && has_samples(tile);
    }
    list_centre(level.x, wanted, index, lane);
}

// Whether the widest window about a tile has any; the sky needs no models.
fn has_samples(centre: vec2<u32>) -> bool {
    let count = select(WINDOW_TILES[frame.widest_window], MOST_TILES, has(frame, FLAG_LIMITED));
    for (var i = 0u; i < count; i++) {
        let tile = vec2<i32>(centre) + window_offset(i);
        if all(tile >= vec2(0)) && all(tile < vec2<i32>(frame.tiles)) {
            if moments[(u32(tile.y) * frame.tiles.x + u32(tile.x)) * TILE_STRIDE][TILE_WEIGHT] > 0.0 {
                return true;
            }
        }
    }
    return false;
}
