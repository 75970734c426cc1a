// Which tiles windows hold, and how far the models that are fitted to them reach. Windows are nested: a cross of five tiles, 3x3,
// 5x5.

const WINDOW_TILES = array(0u, 5u, 9u, 25u); // by window, from 1; 0 is none
const MOST_TILES = 25u;

// Where the i-th tile lies: the centre, its four neighbours, the four corners, the ring about them.
fn window_offset(i: u32) -> vec2<i32> {
    if i == 0u {
        return vec2(0);
    }
    let side = select(select(vec2(2, i32(i - 9u) / 4 - 1), vec2(1, 1), i < 9u), vec2(1, 0), i < 5u);
    let half_turned = select(side, -side, (i & 2u) != 0u);
    return select(half_turned, vec2(-half_turned.y, half_turned.x), (i & 1u) != 0u);
}

const WIDEST_WINDOW = 3u;
const WIDEST_REACH = 2u; // tiles on each side of the centre
const WINDOW_REACHES = array(0.0, 12.0, 12.0, 20.0); // half a window's width in pixels

// Weight of a model at `offset` pixels from the middle of its centre tile: falls to 0 at its window's border.
fn tent(offset: vec2<f32>, chosen: u32) -> f32 {
    let sides = max(1.0 - abs(offset) / WINDOW_REACHES[chosen], vec2(0.0));
    return sides.x * sides.y;
}
