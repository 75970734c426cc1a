// choose: spends what is left of the budget of models on the tiles of one level that gain most, and keeps the models of earlier
// frames elsewhere.
//
// Without a sort: the budget ends in one of the histogram's buckets, and what lies above this one is chosen.
//
// Reads   kept, histogram.
// Writes  centre_list: the chosen tiles; levels: how many, and how many models are kept; windows and coverage of these
// Source  bucket select: Alabi et al., "Fast k-Selection Algorithms for Graphics Processing Units", JEA 2012

//!include frame numbers surface features linear_model windows models listing cover

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> level: vec4<u32>; // its number in x
@group(0) @binding(2) var<storage, read> kept: array<u32>;
@group(0) @binding(3) var<storage, read> histogram: array<u32>;
@group(0) @binding(4) var<storage, read_write> centre_list: array<u32>;
@group(0) @binding(5) var<storage, read_write> levels: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> windows: array<u32>;
@group(0) @binding(7) var<storage, read_write> coverage: array<atomic<u32>>;

const OWN_FEATURES = MODEL_OWN_FEATURES;
const LANES = 64u;
const SHARE = BUCKETS / LANES; // of the buckets, a lane's

var<workgroup> shares: array<u32, LANES>; // tiles in a lane's buckets
var<workgroup> threshold: u32;            // the bucket in which the budget ends; 0 where it does not
var<workgroup> kept_here: atomic<u32>;

@compute @workgroup_size(8, 8)
fn choose(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if lane == 0u {
        threshold = 0u;
        atomicStore(&kept_here, 0u);
    }
    find_threshold(lane);
    let own = frame.levels[level.x];
    let tile = id.xy * own.stride + own.stride / 2u;
    let index = tile.y * frame.tiles.x + tile.x;
    var entry = 0u;
    if all(tile < frame.tiles) {
        entry = kept[index];
    }
    let is_chosen = (entry >> KEPT_BITS) > threshold;
    list_centre(level.x, is_chosen, index, lane);
    let model = entry & ((1u << KEPT_BITS) - 1u);
    if !is_chosen && model != 0u {
        windows[index] = model;
        for (var i = 0u; i < MOST_TILES; i++) {
            cover(tile, stored_window(model), i);
        }
        atomicAdd(&kept_here, 1u);
    }
    workgroupBarrier();
    if lane == 0u {
        atomicAdd(&levels[KEPT_COUNT], atomicLoad(&kept_here));
    }
}

fn find_threshold(lane: u32) {
    var left = frame.model_limit;
    for (var i = 0u; i < level.x; i++) {
        left -= min(left, atomicLoad(&levels[i * LEVEL_WORDS + LEVEL_COUNT]));
    }
    let begin = level.x * BUCKETS + lane * SHARE;
    var share = 0u;
    for (var i = 0u; i < SHARE; i++) {
        share += histogram[begin + i];
    }
    shares[lane] = share;
    workgroupBarrier();
    var above = 0u;
    for (var i = lane + 1u; i < LANES; i++) {
        above += shares[i];
    }
    // In one lane's share at most.
    if above <= left && above + share > left {
        var bucket = SHARE;
        while bucket > 0u && above <= left {
            bucket--;
            above += histogram[begin + bucket];
        }
        threshold = lane * SHARE + bucket;
    }
    workgroupBarrier();
}
