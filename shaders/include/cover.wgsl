// How well models cover the tiles.
//
// A pass binds `coverage`, atomically.

// Adds a model's tent to the coverage of one of the tiles around.
fn cover(place: vec2<u32>, chosen: u32, member: u32) {
    let offset = window_offset(member);
    let tile = vec2<i32>(place) + offset;
    let share = tent(vec2<f32>(offset) * f32(TILE), chosen);
    if all(tile >= vec2(0)) && all(tile < vec2<i32>(frame.tiles)) && share > 0.0 {
        atomicAdd(&coverage[u32(tile.y) * frame.tiles.x + u32(tile.x)], u32(share * f32(COVERAGE_ONE)));
    }
}
