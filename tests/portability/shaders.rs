//! Every pipeline of the library through the browser's validator, and proof that it would refuse a wrong one.

use crate::tint::{Pipeline, Stages, assert_accepts, complaints};
use quell::gpu::{Constants, DECODING, KernelDescriptor, REFLECTIONS, SPECULAR, assemble};
use quell::passes::{ALL, SPECULAR_KERNELS, check, reproject};
use wgpu::naga;

#[test]
fn the_browser_accepts_every_shader() {
    let pipeline = |prefix: &str, constants: &'static Constants, pass: &KernelDescriptor| Pipeline {
        name: format!("{prefix}{}", pass.name),
        wgsl: assemble(pass.source),
        stages: Stages::Compute(pass.name),
        constants,
    };
    let plain = ALL.iter().map(|pass| pipeline("", &[], pass));
    let specular = SPECULAR_KERNELS.iter().map(|pass| pipeline("specular ", SPECULAR, pass));
    let others = [
        ("reflections ", REFLECTIONS, &reproject::DESCRIPTOR),
        ("decoding ", DECODING, &reproject::DESCRIPTOR),
        ("", DECODING, &check::DESCRIPTOR),
    ];
    let others = others.map(|(prefix, constants, pass)| pipeline(prefix, constants, pass));
    let pipelines: Vec<_> = plain.chain(specular).chain(others).collect();
    assert_eq!(pipelines.len(), ALL.len() + SPECULAR_KERNELS.len() + 3);
    assert_accepts(&pipelines);
}

/// What Tint says of a compute shader that naga accepts with every check it has.
fn complaint(wgsl: &str, constants: &Constants) -> String {
    let module = naga::front::wgsl::parse_str(wgsl).unwrap();
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
        .validate(&module)
        .unwrap();
    let pipeline =
        Pipeline { name: "wrong".into(), wgsl: wgsl.into(), stages: Stages::Compute("f"), constants };
    complaints(&[pipeline]).remove(0).1
}

#[test]
fn the_browser_refuses_a_barrier_that_some_invocations_miss() {
    let wgsl = "
        @group(0) @binding(0) var<storage, read_write> data: array<u32>;
        @compute @workgroup_size(64) fn f(@builtin(local_invocation_index) i: u32) {
            if data[i] > 0u { workgroupBarrier(); }
            data[i] = 1u;
        }";
    let found = complaint(wgsl, &[]);
    assert!(found.contains("must only be called from uniform control flow"), "{found}");
    let found = complaint(&wgsl.replace("data[i] > 0u", "arrayLength(&data) > 0u"), &[]);
    assert_eq!(found, "");
}

#[test]
fn the_browser_looks_at_pipelines_with_their_constants() {
    let wgsl = "
        @group(0) @binding(0) var<storage, read_write> data: array<u32>;
        override LAST = 3u;
        @compute @workgroup_size(64) fn f() { data[0] = array<u32, 4>(1u, 2u, 3u, 4u)[LAST]; }";
    assert_eq!(complaint(wgsl, &[("LAST", 3.0)]), "");
    let found = complaint(wgsl, &[("LAST", 4.0)]);
    assert!(found.contains("out of bounds"), "{found}");
}

#[test]
fn the_browser_holds_pipelines_against_the_default_limits() {
    let wgsl = "
        @group(0) @binding(0) var<storage, read_write> data: array<u32>;
        var<workgroup> shared_words: array<u32, 4096>;
        @compute @workgroup_size(64) fn f(@builtin(local_invocation_index) i: u32) {
            shared_words[i] = data[i];
            workgroupBarrier();
            data[i] = shared_words[63u - i];
        }";
    assert_eq!(complaint(wgsl, &[]), "");
    let found = complaint(&wgsl.replace("4096", "4097"), &[]);
    assert!(found.contains("workgroup"), "{found}");
}
