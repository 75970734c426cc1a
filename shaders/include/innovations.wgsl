// The models of the change of the light between the history and this frame's samples, one at every other tile or fewer: light changes
// smoothly. Their features are those of the surface; not the history itself: single bright pixels of it would pass for light
// that left.

const INNOVATION_OWN_FEATURES = 0u;
const INNOVATION_TILES = 2u; // from one centre to the next

// The same where there may be fewer centres, because moments are sparse.
fn innovation_tiles(frame: Frame) -> u32 {
    return select(INNOVATION_TILES, 2u * INNOVATION_TILES, has(frame, FLAG_SPARSE));
}

// The head of a model (include/linear_model): samples in its window; variance of one of them; its significance, by which what the
// model says is shrunk already. It is 0 nearly everywhere while light is steady.
const HEAD_SAMPLES = 0u;
const HEAD_VARIANCE = 1u;
const HEAD_SIGNIFICANCE = 2u;

// Centres of the innovation, the first of which is the first of the tiles.
fn innovation_centres(frame: Frame) -> vec2<u32> {
    let step = innovation_tiles(frame);
    return (frame.tiles + step - 1u) / step;
}
