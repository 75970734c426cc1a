// What BMFR's accumulations share: where a pixel's history is, found by the first one, in 8 bytes.

// Four weights of 8 bits and the pixel that they begin at. Weights are positive or there is no history.
fn pack_taps(taps: Taps) -> vec2<u32> {
    let base = vec2<u32>(taps.base) & vec2(0xffffu);
    return vec2(pack4x8unorm(taps.weights), base.x | (base.y << 16u));
}

fn unpack_taps(packed: vec2<u32>) -> Taps {
    let base = vec2<i32>(vec2(packed.y << 16u, packed.y)) >> vec2(16u);
    let weights = unpack4x8unorm(packed.x);
    // Rounding moved their sum.
    return Taps(base, weights / max(dot(weights, vec4(1.0)), 1e-6));
}
