//! Every shader is valid with no optional capability and within WebGPU's default limits.

use quell_demo::tracer::shaders;
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
