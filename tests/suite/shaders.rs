//! Every shader, as the GPU compiles it, is portable WGSL and agrees with its Rust descriptor.

use quell::gpu::{KernelDescriptor, Kind, assemble};
use wgpu::naga;

/// Those of the denoiser, and the check's.
fn kernels() -> impl Iterator<Item = &'static KernelDescriptor> {
    quell::passes::ALL.into_iter().chain([&quell::passes::check::DESCRIPTOR])
}

fn module(pass: &KernelDescriptor) -> naga::Module {
    let source = assemble(pass.source);
    naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|error| panic!("{}: {}", pass.name, error.emit_to_string(&source)))
}

/// Packing pairs of half floats is part of WGSL, for which naga has a capability because old OpenGL lacks it. No other is used, and
/// this one only by shaders that pack.
fn capabilities(source: &str) -> naga::valid::Capabilities {
    if source.contains("pack2x16float(") {
        naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32
    } else {
        naga::valid::Capabilities::empty()
    }
}

/// Also leaves the assembled shaders in `target/tmp/shaders`, for `naga --capabilities none` and other tools.
#[test]
fn every_shader_is_valid_without_optional_capabilities() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("shaders");
    std::fs::create_dir_all(&folder).unwrap();
    for pass in kernels() {
        let module = module(pass);
        let source = assemble(pass.source);
        std::fs::write(folder.join(format!("{}.wgsl", pass.name)), &source).unwrap();
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities(&source))
            .validate(&module)
            .unwrap_or_else(|error| panic!("{}: {}", pass.name, error.emit_to_string(&source)));
    }
}

#[test]
fn packing_halves_is_in_the_core_of_webgpu() {
    assert!(wgpu::DownlevelFlags::compliant().contains(wgpu::DownlevelFlags::SHADER_F16_IN_F32));
}

#[test]
fn the_validator_refuses_a_shader_that_needs_a_capability() {
    let source = "@compute @workgroup_size(1) fn f() { var x: f64 = 1.0lf; x += 1.0lf; }";
    let valid = naga::front::wgsl::parse_str(source).is_ok_and(|module| {
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities(source))
            .validate(&module)
            .is_ok()
    });
    assert!(!valid);
}

#[test]
fn passes_are_listed_in_order_under_one_name() {
    // What runs within another pass is none of its own: that of levels in `fit`, that of what is counted in `sample_map`.
    let within = ["centres", "gains", "choose", "sample_gains", "sample_rate"];
    let names: Vec<_> =
        quell::passes::ALL.iter().map(|pass| pass.name).filter(|name| !within.contains(name)).collect();
    let specular = names[..quell::PASSES.len() - names.len()].iter().map(|name| format!("specular {name}"));
    let (of_signal, others) = names.split_at(specular.len());
    let expected: Vec<_> = (of_signal.iter().map(ToString::to_string))
        .chain(specular)
        .chain(others.iter().map(ToString::to_string))
        .collect();
    assert_eq!(expected, quell::PASSES);
}

#[test]
fn entry_points_and_workgroups_match_their_descriptors() {
    for pass in kernels() {
        let module = module(pass);
        let [entry] = module.entry_points.as_slice() else { panic!("{}: not one entry point", pass.name) };
        assert_eq!(entry.name, pass.name);
        let [x, y] = pass.workgroup;
        assert_eq!(entry.workgroup_size, [x, y, 1], "{}", pass.name);
    }
}

#[test]
fn binding_tables_match_the_shaders() {
    for pass in kernels() {
        let module = module(pass);
        let mut found: Vec<_> = module
            .global_variables
            .iter()
            .filter_map(|(_, variable)| {
                let binding = variable.binding?;
                assert_eq!(binding.group, 0, "{}", pass.name);
                Some((binding.binding, variable.name.clone().unwrap(), kind(&module, variable)))
            })
            .collect();
        found.sort_by_key(|&(binding, ..)| binding);
        let expected: Vec<_> =
            (0..).zip(pass.bindings).map(|(i, &(name, kind))| (i, name.to_owned(), kind)).collect();
        assert_eq!(found, expected, "{}", pass.name);
        let stores = pass.bindings.iter().filter(|(_, kind)| matches!(kind, Kind::Storage(_))).count();
        assert!(stores <= 4, "{}: WebGPU's default limit is 4 storage textures", pass.name);
    }
}

#[test]
fn workgroup_memory_is_what_the_library_asks_for() {
    let bytes = |pass: &KernelDescriptor| -> u64 {
        let module = module(pass);
        let mut layouter = naga::proc::Layouter::default();
        layouter.update(module.to_ctx()).unwrap();
        let shared = module.global_variables.iter().filter(|(_, v)| v.space == naga::AddressSpace::WorkGroup);
        shared.map(|(_, variable)| u64::from(layouter[variable.ty].to_stride())).sum()
    };
    let largest = quell::passes::ALL.into_iter().map(bytes).max().unwrap();
    let asked = quell::layout::WORKGROUP_BYTES;
    assert!((asked / 2..=asked).contains(&largest), "{largest} bytes, asked for {asked}");
    assert!(asked <= wgpu::Limits::default().max_compute_workgroup_storage_size.into());
}

fn kind(module: &naga::Module, variable: &naga::GlobalVariable) -> Kind {
    use naga::{AddressSpace, ImageClass, ScalarKind, StorageAccess, StorageFormat, TypeInner};
    match (variable.space, &module.types[variable.ty].inner) {
        (AddressSpace::Uniform, TypeInner::Vector { .. }) => Kind::Uniform,
        (AddressSpace::Uniform, _) => Kind::Frame,
        (AddressSpace::Storage { access }, _) if access.contains(StorageAccess::STORE) => Kind::BufferMut,
        (AddressSpace::Storage { .. }, _) => Kind::Buffer,
        (_, TypeInner::Image { class: ImageClass::Sampled { kind: ScalarKind::Uint, .. }, .. }) => {
            Kind::TextureUint
        }
        (_, TypeInner::Image { class: ImageClass::Sampled { .. }, .. }) => Kind::Texture,
        (_, TypeInner::Image { class: ImageClass::Storage { format, .. }, .. }) => {
            Kind::Storage(match format {
                StorageFormat::Rgba16Float => wgpu::TextureFormat::Rgba16Float,
                StorageFormat::R32Uint => wgpu::TextureFormat::R32Uint,
                StorageFormat::Rg32Uint => wgpu::TextureFormat::Rg32Uint,
                other => panic!("format {other:?} is not used by any binding table"),
            })
        }
        (space, inner) => panic!("unexpected binding: {space:?} {inner:?}"),
    }
}

#[test]
fn headers_state_purpose_reads_and_writes() {
    for pass in kernels() {
        assert!(pass.source.starts_with(&format!("// {}: ", pass.name)), "{}: purpose", pass.name);
        for heading in ["// Reads", "// Writes"] {
            assert!(pass.source.contains(heading), "{}: {heading}", pass.name);
        }
    }
}
