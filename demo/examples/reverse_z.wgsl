// A G-buffer as other engines have it; joined to boxes.wgsl. Depth is what the depth buffer holds.

struct OtherSurface {
    @location(0) normal: vec2f,
    @location(1) roughness: f32,
    @location(2) motion_px: vec2f,
}

@fragment
fn other_gbuffer(corner: Corner) -> OtherSurface {
    let normal = (frame.view_from_world * vec4f(corner.normal, 0.0)).xyz;
    // From where the surface was to where it is, in pixels.
    let motion_px = -motion_uv(corner) * vec2f(frame.size);
    return OtherSurface(octahedral(normal), ROUGHNESS, motion_px);
}

/// Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors", JCGT 2014.
fn octahedral(normal: vec3f) -> vec2f {
    let p = normal.xy / (abs(normal.x) + abs(normal.y) + abs(normal.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0));
    return select(folded, p, normal.z >= 0.0);
}
