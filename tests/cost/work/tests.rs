//! Counts of shaders that are small enough to count by hand.

use super::*;
use quell::gpu::KernelDescriptor;

fn walked(body: &'static str, left_out: &[&str]) -> Work {
    let source = format!(
        "@group(0) @binding(0) var image: texture_2d<f32>;
         @group(0) @binding(1) var<storage, read_write> buffer: array<f32>;
         var<workgroup> shared_words: array<vec2<f32>, 64>;
         fn is_so() -> bool {{ return buffer[0] > 0.0; }}
         fn has(bits: f32, flag: u32) -> bool {{ return (bitcast<u32>(bits) & flag) != 0u; }}
         fn tap(x: i32) -> f32 {{ return textureLoad(image, vec2(x), 0).x; }}
         @compute @workgroup_size(64)
         fn main(@builtin(local_invocation_index) lane: u32) {{ {body} }}"
    );
    let descriptor = KernelDescriptor {
        name: "main",
        source: source.leak(),
        bindings: &[],
        workgroup: [64, 1],
        covers: [1, 1],
    };
    of(&Shader::new(Box::leak(Box::new(descriptor))), left_out)
}

#[test]
fn loops_count_as_often_as_they_run() {
    let taps = |body, left_out: &[&str]| walked(body, left_out).texels;
    assert_eq!(
        taps("for (var y = -2; y <= 2; y++) { for (var x = 0; x < 3; x++) { _ = tap(x); } }", &[]),
        15
    );
    assert_eq!(taps("for (var i = lane; i < 130u; i += 64u) { _ = tap(0); }", &[]), 3);
    assert_eq!(taps("for (var i = 0; i < 8; i++) { if i == 5 { break; } _ = tap(0); }", &[]), 5);
    assert_eq!(taps("for (var i = 0; i < 8; i++) { if i % 2 == 0 { continue; } _ = tap(0); }", &[]), 4);
    assert_eq!(taps("for (var i = 0; i < 8; i++) { _ = tap(i); }", &["tap"]), 0);
    assert_eq!(taps("for (var i = 0; i < select(4, 4, buffer[0] > 0.0); i++) { _ = tap(0); }", &[]), 4);
}

#[test]
fn what_is_left_out_is_false() {
    let body = "var so = is_so();
        for (var i = 0; i < 4 || (so && i < 12); i++) {
            _ = tap(0);
            if buffer[i] > 0.0 { so = false; }
        }";
    assert_eq!([&["is_so"][..], &[]].map(|left_out| walked(body, left_out).texels), [4, 12]);
}

#[test]
fn flags_that_defaults_do_not_set_are_off() {
    let has = |flag: u32| {
        let body = format!("if has(buffer[0], {flag}u) {{ _ = tap(0); }}");
        walked(body.leak(), &[]).texels
    };
    assert_eq!([quell::gpu::flags::RING_ERROR, quell::gpu::flags::MIX].map(has), [0, 1]);
}

#[test]
fn a_barrier_counts_as_often_as_it_is_met() {
    let body = "workgroupBarrier(); for (var i = 0; i < 3; i++) { workgroupBarrier(); }";
    assert_eq!(walked(body, &[]).barriers, 4);
}

#[test]
fn data_take_all_branches_and_leave_loops_at_their_end() {
    let taps = |body| walked(body, &[]).texels;
    assert_eq!(taps("if buffer[0] > 0.0 { _ = tap(0); } else { _ = tap(1); }"), 2);
    assert_eq!(taps("for (var i = 0; i < 30; i++) { if buffer[i] > 0.0 { continue; } _ = tap(0); }"), 30);
    let unbounded = "var i = 0; while buffer[i] > 0.0 { i++; _ = tap(0); }";
    assert_eq!(taps(unbounded), u64::from(ASSUMED_ROUNDS));
}

#[test]
fn one_invocation_is_enough_and_none_is_free() {
    assert_eq!(walked("if lane == 63u { buffer[0] = 1.0; }", &[]).buffers, 1);
    assert_eq!(walked("if lane == 64u { buffer[0] = 1.0; }", &[]).buffers, 0);
    assert_eq!(walked("if lane > 9u { return; } if lane > 20u { buffer[0] = 1.0; }", &[]).buffers, 0);
    assert_eq!(walked("shared_words[lane] = vec2(1.0);", &[]).shared, 2);
}

#[test]
fn what_is_left_out_exists() {
    let shaders = Shader::all();
    for name in LEFT_OUT.concat() {
        let mut functions = shaders.iter().flat_map(|shader| shader.module.functions.iter());
        let found = functions.any(|(_, function)| function.name.as_deref() == Some(name));
        assert!(found, "tests/cost/work.rs leaves out `{name}`, which no shader has");
    }
}
