//! Every shader is valid with no optional capability and within WebGPU's default limits.

use crate::tint::{Pipeline, Stages, assert_accepts, complaints};
use quell_demo::{peers, tracer::shaders};
use std::path::{Path, PathBuf};
use wgpu::naga;

fn validated(name: &str, source: &str) -> naga::Module {
    let module = naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
    if let Err(error) = validator.validate(&module) {
        panic!("{name}: {}", error.emit_to_string(source));
    }
    module
}

#[test]
fn shaders_are_valid_within_default_limits() {
    for pass in shaders::passes() {
        let source = shaders::source(pass).expect("all includes exist");
        check_limits(pass, &validated(pass, &source));
        assert!(source.starts_with(&format!("// {pass}:")), "{pass} does not say what it is for");
    }
}

/// Files of a folder of shaders: name without ending, and text.
fn files(folder: &str) -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders").join(folder);
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let shaders = paths.filter(|path| path.extension().is_some_and(|ending| ending == "wgsl"));
    let read = |path: PathBuf| {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        (name, std::fs::read_to_string(path).unwrap())
    };
    shaders.map(read).collect()
}

#[test]
fn no_file_is_left_unchecked() {
    // The window's shaders stand alone.
    let alone = files("").into_iter().filter(|(name, _)| shaders::source(name).is_none());
    for (name, text) in alone {
        assert!(!validated(&name, &text).entry_points.is_empty(), "{name}");
    }
    let passes: String = shaders::passes().filter_map(shaders::source).collect();
    for (name, text) in files("include") {
        assert!(passes.contains(&text), "include/{name} is in no pass");
    }
}

fn check_limits(pass: &str, module: &naga::Module) {
    let limits = wgpu::Limits::default();
    let (mut storage, mut sampled) = (0, 0);
    for (_, variable) in module.global_variables.iter() {
        let naga::TypeInner::Image { class, .. } = module.types[variable.ty].inner else {
            continue;
        };
        match class {
            naga::ImageClass::Storage { .. } => storage += 1,
            _ => sampled += 1,
        }
    }
    assert!(storage <= limits.max_storage_textures_per_shader_stage, "{pass}: {storage} storage textures");
    assert!(sampled <= limits.max_sampled_textures_per_shader_stage, "{pass}: {sampled} sampled textures");
    for entry in &module.entry_points {
        assert_eq!(entry.name, pass);
        // Dispatch sizes are counted in groups of this size.
        let expected = if pass.starts_with("trace") { [64, 1, 1] } else { [8, 8, 1] };
        assert_eq!(entry.workgroup_size, expected, "{pass}");
    }
}

#[test]
fn a_missing_include_is_noticed() {
    assert!(shaders::source("no such pass").is_none());
}

/// The shader that draws; the others compute.
fn display(wgsl: &str) -> Pipeline<'static> {
    let stages = Stages::Render { vertex: "vertex", fragment: "fragment" };
    Pipeline { name: "display".into(), wgsl: wgsl.into(), stages, constants: &[] }
}

#[test]
fn the_browser_accepts_every_shader() {
    let compute = |name: &'static str, wgsl, constants| Pipeline {
        name: name.into(),
        wgsl,
        stages: Stages::Compute(name),
        constants,
    };
    let tracer = shaders::passes().map(|name| compute(name, shaders::source(name).unwrap(), &[]));
    let peers = peers::shaders::passes().flat_map(|name| {
        let wgsl = peers::shaders::source(name);
        // The one constant there is; each level of the filter steps wider.
        let is_stepped = wgsl.contains("override STEP");
        let steps: &[&[(&str, f64)]] =
            if is_stepped { &[&[("STEP", 1.0)], &[("STEP", 16.0)]] } else { &[&[]] };
        steps.iter().map(move |constants| compute(name, wgsl.clone(), constants))
    });
    let pipelines: Vec<_> = tracer.chain(peers).chain([display(DISPLAY)]).collect();
    assert!(pipelines.len() > shaders::passes().count() + peers::shaders::passes().count() + 1);
    assert_accepts(&pipelines);
}

#[test]
fn the_browser_refuses_a_derivative_that_some_pixels_miss() {
    let entry = "@fragment\nfn fragment(in: Vertex) -> @location(0) vec4<f32> {";
    assert!(DISPLAY.contains(entry));
    let wrong =
        DISPLAY.replace(entry, &format!("{entry}\n if in.uv.x > 0.5 {{ return vec4(dpdx(in.uv.x)); }}"));
    validated("display", &wrong);
    let found = complaints(&[display(&wrong)]).remove(0).1;
    assert!(found.contains("uniform control flow"), "{found}");
}

const DISPLAY: &str = include_str!("../../shaders/display.wgsl");
