// How long what a surface showed says what it shows now.
//
// Source: half vectors turn by half of what the light's direction does: Walter et al., "Microfacet Models for Refraction
// through Rough Surfaces", EGSR 2007

// Half-width of what a microfacet lobe gathers, in the square of linear roughness, radians.
const LOBE_WIDTH = 2.0;
const LEAST_MEMORY = 3.0;  // frames
const STILL_TURN = 1e-4;   // radians in a frame

// Frames that history may count for: as many as it takes the view of the surface to turn by the width of its lobe. Before that a
// glossy surface showed something else.
fn memory(surface: Surface, position: vec3<f32>) -> f32 {
    let now = towards_eye(frame.current, position);
    let turn = length(now - towards_eye(frame.previous, position + frame.eye_delta));
    let width = LOBE_WIDTH * surface.roughness * surface.roughness;
    return select(max(width / turn, LEAST_MEMORY), HALF_MAX, turn < STILL_TURN);
}
