// Rows of BMFR's least-squares problem: ten features and the three channels that they are fitted to.

// 1, normal, position, squared position.
const FEATURES = 10u;
const COLUMNS = 13u;

// Columns 0 to 3, 4 to 7, 8 to 11, 12.
struct Row {
    a: vec4<f32>,
    b: vec4<f32>,
    c: vec4<f32>,
    d: f32,
}

fn row_of(normal: vec3<f32>, position: vec3<f32>, signal: vec3<f32>) -> Row {
    let squared = position * position;
    return Row(vec4(1.0, normal), vec4(position, squared.x), vec4(squared.yz, signal.rg), signal.b);
}

// Column k, without indexing registers.
fn entry(row: Row, k: u32) -> f32 {
    let four = select(select(row.a, row.b, k >= 4u), row.c, k >= 8u);
    return dot(four, select(vec4(0.0), vec4(1.0), vec4(0u, 1u, 2u, 3u) == vec4(k & 3u)));
}

fn add_scaled(row: Row, scale: f32, by: Row) -> Row {
    return Row(row.a + scale * by.a, row.b + scale * by.b, row.c + scale * by.c, row.d + scale * by.d);
}
