// The models of the change of the light between the history and this frame's samples: how they lie in memory, one per tile.
// Their features are those of the surface; not the history itself: single bright pixels of it would pass for light that left.

const INNOVATION_OWN_FEATURES = 0u;

// A model in memory: samples in its window; variance of one of them; then the change at the origin
// with the features there, and slopes per feature and channel. Both are shrunk by their significance already.
const INNOVATION_SAMPLES = 0u;
const INNOVATION_VARIANCE = 1u;
const INNOVATION_MEAN = 2u;
const INNOVATION_SLOPE = INNOVATION_MEAN + SURFACE_FEATURES + CHANNELS;
const INNOVATION_STRIDE = INNOVATION_SLOPE + SURFACE_FEATURES * CHANNELS;
