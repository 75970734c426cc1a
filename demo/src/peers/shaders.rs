//! The peers' WGSL, joined from files: a line `//!include name` stands for `shaders/peers/include/name.wgsl`.

use crate::compute::{Binding, Pass, PassDescriptor, join_wgsl, wgsl_files};

/// Every pass, by the name of its file and its entry point.
const PASSES: [(&str, &str); 10] = wgsl_files![
    "peers/",
    "accumulate",
    "antialias",
    "svgf_temporal",
    "svgf_variance",
    "svgf_atrous",
    "svgf_compose",
    "bmfr_accumulate",
    "bmfr_fit",
    "bmfr_blend",
    "bmfr_taa",
];

const INCLUDES: [(&str, &str); 11] = wgsl_files![
    "peers/",
    "include/frame",
    "include/toned",
    "include/surface",
    "include/taps",
    "include/reproject",
    "include/signal",
    "include/svgf_state",
    "include/svgf_edges",
    "include/svgf_level",
    "include/bmfr",
    "include/bmfr_rows",
];

/// Edge of the square workgroup of every pass that works pixel by pixel.
const WORKGROUP: u32 = 8;

/// Names of the passes.
pub fn passes() -> impl Iterator<Item = &'static str> {
    PASSES.into_iter().map(|(name, _)| name)
}

/// The WGSL of a pass with everything it includes.
///
/// # Panics
/// For a name that is no pass.
pub fn source(name: &str) -> String {
    let found = PASSES.into_iter().find(|(file, _)| *file == name);
    // The tests join all of them.
    found.and_then(|(_, text)| join_wgsl(text, &INCLUDES)).expect("a shader or an include is missing")
}

/// A pass that works pixel by pixel.
pub fn pass(
    device: &wgpu::Device,
    name: &'static str,
    bindings: &[Binding],
    constants: &[(&str, f64)],
) -> Pass {
    let source = source(name);
    Pass::new(device, PassDescriptor { name, source, shared: &[], bindings, constants, tile: WORKGROUP })
}

/// A pass of which a workgroup works on a block of pixels.
pub fn block_pass(device: &wgpu::Device, name: &'static str, bindings: &[Binding], tile: u32) -> Pass {
    let source = source(name);
    Pass::new(device, PassDescriptor { name, source, shared: &[], bindings, constants: &[], tile })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader_check::validated;

    /// Workgroup memory that every WebGPU device has.
    const WORKGROUP_BYTES: u32 = 16 * 1024;

    #[test]
    fn every_pass_is_valid_and_within_the_limits_of_webgpu() {
        for (name, _) in PASSES {
            let module = validated(&source(name));
            let entry = &module.entry_points[0];
            assert_eq!(entry.name, name);
            let [x, y, z] = entry.workgroup_size;
            assert!(x * y * z <= 256, "{name}");
            assert!(name == "bmfr_fit" || [x, y, z] == [WORKGROUP, WORKGROUP, 1], "{name}");
            let bytes: u32 = module
                .global_variables
                .iter()
                .filter(|(_, variable)| variable.space == wgpu::naga::AddressSpace::WorkGroup)
                .map(|(_, variable)| module.types[variable.ty].inner.size(module.to_ctx()))
                .sum();
            assert!(bytes <= WORKGROUP_BYTES, "{name}: {bytes}");
        }
    }

    #[test]
    fn no_file_is_left_unchecked() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/peers");
        for (folder, known) in
            [(folder.clone(), PASSES.map(|(name, _)| name).to_vec()), (folder.join("include"), included())]
        {
            for file in std::fs::read_dir(folder).unwrap() {
                let path = file.unwrap().path();
                let name = path.file_stem().unwrap().to_str().unwrap();
                assert!(path.is_dir() || known.contains(&name), "{name} is in no pass");
            }
        }
    }

    /// Names of the includes that some pass uses.
    fn included() -> Vec<&'static str> {
        let all: String = PASSES.into_iter().map(|(name, _)| source(name)).collect();
        let used = INCLUDES.into_iter().filter(|(_, text)| all.contains(*text));
        used.map(|(name, _)| name.trim_start_matches("include/")).collect()
    }
}
