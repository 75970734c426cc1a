// The error image: how far the output is expected to be off, beside its luminance.

struct OutputError {
    deviation: f32, // root of the mean squared error of luminance, radiance
    luminance: f32, // of the radiance
}

fn pack_error(e: OutputError) -> u32 {
    return pack2x16float(clamp(vec2(e.deviation, e.luminance), vec2(0.0), vec2(HALF_MAX)));
}

fn unpack_error(word: u32) -> OutputError {
    let parts = unpack2x16float(word);
    return OutputError(parts.x, parts.y);
}
