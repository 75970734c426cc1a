// Lists the centres of a level, a workgroup at a time.
//
// A pass binds `centre_list`, and `levels` atomically.

var<workgroup> listed: atomic<u32>;
var<workgroup> first: u32;

// Call from uniform control flow, once.
fn list_centre(number: u32, wanted: bool, index: u32, lane: u32) {
    var place = 0u;
    if lane == 0u {
        atomicStore(&listed, 0u);
    }
    workgroupBarrier();
    if wanted {
        place = atomicAdd(&listed, 1u);
    }
    workgroupBarrier();
    if lane == 0u {
        reserve(number, atomicLoad(&listed));
    }
    workgroupBarrier();
    if wanted {
        centre_list[first + place] = index;
    }
}

// Makes room in the list for a workgroup's centres.
fn reserve(number: u32, count: u32) {
    let start = number * LEVEL_WORDS;
    first = atomicAdd(&levels[start + LEVEL_COUNT], count);
    let rows = (first + count + LEVEL_COLUMNS - 1u) / LEVEL_COLUMNS;
    atomicMax(&levels[start + LEVEL_ROWS], rows);
    atomicStore(&levels[start], LEVEL_COLUMNS);
    atomicStore(&levels[start + 2u], 1u);
}
