//! For tests: that a uniform's struct in WGSL is the one in Rust, and that a shader is valid.

use wgpu::naga::front::wgsl::parse_str;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};
use wgpu::naga::{Module, TypeInner};

/// Parses a shader and validates it with no capability beyond WebGPU's core.
pub fn validated(source: &str) -> Module {
    let module = parse_str(source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)));
    // Packing halves is in WebGPU's core; only where that is not all there is does naga ask for it.
    let core = Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    let validated = Validator::new(ValidationFlags::all(), core).validate(&module);
    validated.unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)));
    module
}

/// Compares names, offsets and size of a struct.
pub fn assert_layout(module: &Module, name: &str, expected: &[(&str, usize)], expected_size: usize) {
    let (_, found) =
        module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).expect("no such struct");
    let TypeInner::Struct { members, span } = &found.inner else {
        panic!("{name} is no struct");
    };
    let found: Vec<_> =
        members.iter().map(|member| (member.name.as_deref().unwrap_or(""), member.offset as usize)).collect();
    assert_eq!(found, expected);
    assert_eq!(*span as usize, expected_size);
}
