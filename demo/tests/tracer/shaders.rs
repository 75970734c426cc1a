//! Every shader is valid with no optional capability and within WebGPU's default limits.

use quell_demo::tracer::shaders;
use wgpu::naga;

#[test]
fn shaders_are_valid_within_default_limits() {
    for pass in shaders::passes() {
        let source = shaders::source(pass).expect("all includes exist");
        let module = naga::front::wgsl::parse_str(&source)
            .unwrap_or_else(|error| panic!("{pass}: {}", error.emit_to_string(&source)));
        let mut validator = naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::empty(),
        );
        if let Err(error) = validator.validate(&module) {
            panic!("{pass}: {}", error.emit_to_string(&source));
        }
        check_limits(pass, &module);
        assert!(source.starts_with(&format!("// {pass}:")), "{pass} does not say what it is for");
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
        assert_eq!(entry.workgroup_size, [8, 8, 1], "{pass}");
    }
}

#[test]
fn a_missing_include_is_noticed() {
    assert!(shaders::source("no such pass").is_none());
}
