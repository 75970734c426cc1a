// SVGF's edge-stopping functions on geometry: section 4.4. Depth is view depth,
// which like the paper's clip-space depth is not divided by w.

// The paper's values (section 4.4).
const SIGMA_DEPTH = 1.0;
const SIGMA_NORMAL = 128.0;
// The small value that the paper adds against division by zero, as a part of depth. Along lines of equal depth it is
// what surfaces may curve by.
const DEPTH_EPSILON = 1e-3;

// Weight of a tap at `offset` pixels from a centre whose depth has this slope; 0 at a miss and on another surface.
fn geometry_weight(
    center: vec2<u32>, normal: vec3<f32>, slope: vec2<f32>, tap: vec2<u32>, offset: vec2<f32>,
) -> f32 {
    let d = depth_of(center);
    let tap_d = depth_of(tap);
    if tap_d == 0.0 || id_of(tap) != id_of(center) {
        return 0.0;
    }
    let steps = abs(tap_d - d) / d / (SIGMA_DEPTH * abs(dot(slope, offset)) + DEPTH_EPSILON);
    return exp(-steps) * pow(max(dot(normal, normal_of(tap)), 0.0), SIGMA_NORMAL);
}
