//! Rust's mirrors of WGSL structs and constants, compared with what naga reflects.

use quell::gpu::{FrameUniforms, ViewUniforms, assemble, flags};
use quell::layout;
use std::mem::offset_of;
use wgpu::naga;

fn reflect(includes: &str) -> naga::Module {
    naga::front::wgsl::parse_str(&assemble(&format!("//!include {includes}"))).unwrap()
}

fn members(module: &naga::Module, wanted: &str) -> (Vec<(String, usize)>, usize) {
    let (_, found) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(wanted)).unwrap();
    let naga::TypeInner::Struct { members, span } = &found.inner else { panic!("{wanted} is no struct") };
    let list = members.iter().map(|m| (m.name.clone().unwrap(), m.offset as usize)).collect();
    (list, *span as usize)
}

macro_rules! mirror {
    ($type:ty, $($field:ident),+ $(,)?) => {
        (vec![$((stringify!($field).to_owned(), offset_of!($type, $field))),+], size_of::<$type>())
    };
}

#[test]
fn frame_uniforms_match_the_wgsl() {
    let module = reflect("frame numbers");
    let view = mirror!(
        ViewUniforms,
        view_from_world,
        scale,
        shift,
        offset,
        jitter,
        perspective,
        pad_0,
        pad_1,
        pad_2
    );
    let frame = mirror!(
        FrameUniforms,
        current,
        previous,
        eye_delta,
        far,
        size,
        tiles,
        centres,
        window_radius,
        index,
        motion_scale,
        max_history,
        flags,
        debug_view,
        pad_0,
        pad_1,
        pad_2,
    );
    assert_eq!(members(&module, "View"), view);
    assert_eq!(members(&module, "Frame"), frame);
}

fn constant(module: &naga::Module, wanted: &str) -> u32 {
    let (_, found) = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(wanted)).unwrap();
    match module.global_expressions[found.init] {
        naga::Expression::Literal(naga::Literal::U32(value)) => value,
        ref other => panic!("{wanted} is {other:?}"),
    }
}

#[test]
fn constants_match_the_wgsl() {
    let module = reflect("frame numbers surface features");
    let expected = [
        ("TILE", layout::TILE),
        ("CENTRE_STRIDE", layout::CENTRE_STRIDE),
        ("FEATURES", layout::FEATURES),
        ("COLUMNS", layout::COLUMNS),
        ("SQUARES", layout::SQUARES),
        ("HALF_SQUARES", layout::HALF_SQUARES),
        ("TILE_STRIDE", layout::TILE_STRIDE),
        ("MODEL_STRIDE", layout::MODEL_STRIDE),
        ("FLAG_HISTORY", flags::HISTORY),
        ("FLAG_SURFACE_ID", flags::SURFACE_ID),
        ("FLAG_EMISSION", flags::EMISSION),
        ("FLAG_SAMPLE_COUNT", flags::SAMPLE_COUNT),
        ("FLAG_MOTION_DEPTH", flags::MOTION_DEPTH),
        ("FLAG_MIX", flags::MIX),
    ];
    for (name, value) in expected {
        assert_eq!(constant(&module, name), value, "{name}");
    }
}

#[test]
fn debug_views_match_the_wgsl() {
    let source = assemble(quell::passes::debug_view::DESCRIPTOR.source);
    let module = naga::front::wgsl::parse_str(&source).unwrap();
    for view in quell::DebugView::ALL {
        let screaming = format!("{view:?}").chars().fold(String::from("VIEW"), |name, c| {
            if c.is_uppercase() { format!("{name}_{c}") } else { format!("{name}{}", c.to_ascii_uppercase()) }
        });
        assert_eq!(constant(&module, &screaming), view as u32, "{screaming}");
    }
}
