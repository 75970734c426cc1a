//! Rust's mirrors of WGSL structs and constants, compared with what naga reflects.

use quell::gpu::{FrameUniforms, LevelUniforms, ViewUniforms, assemble, flags};
use quell::layout::{self, Columns};
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
    let view = mirror!(ViewUniforms, view_from_world, scale, shift, offset, jitter, perspective, pad_0, size);
    let frame = mirror!(
        FrameUniforms,
        size,
        tiles,
        motion_scale,
        max_history,
        flags,
        index,
        debug_view,
        least_window,
        widest_window,
        firefly_limit,
        far,
        sample_budget,
        dark_level,
        origin,
        motion_offset,
        unprojection,
        levels,
        eye_delta,
        model_limit,
        current,
        previous,
    );
    assert_eq!(members(&module, "View"), view);
    assert_eq!(members(&module, "Frame"), frame);
    assert_eq!(members(&module, "Level"), mirror!(LevelUniforms, stride, covered, pad_0, pad_1));
}

/// The numbers of a constant: one, or those of an array.
fn numbers(module: &naga::Module, wanted: &str) -> Vec<f64> {
    use naga::{Expression, Literal};
    let mut constants = module.constants.iter().map(|(_, constant)| constant);
    let found = constants.find(|c| c.name.as_deref() == Some(wanted)).unwrap();
    let number = |expression| match module.global_expressions[expression] {
        Expression::Literal(Literal::U32(value)) => value.into(),
        Expression::Literal(Literal::F32(value)) => value.into(),
        ref other => panic!("{wanted} is {other:?}"),
    };
    match module.global_expressions[found.init] {
        Expression::Compose { ref components, .. } => components.iter().copied().map(number).collect(),
        _ => vec![number(found.init)],
    }
}

fn constant(module: &naga::Module, wanted: &str) -> u32 {
    let [value] = numbers(module, wanted)[..] else { panic!("{wanted} is an array") };
    assert_eq!(value.fract(), 0.0, "{wanted}");
    value as u32
}

#[test]
fn constants_match_the_wgsl() {
    let module = reflect("frame numbers");
    let expected = [
        ("TILE", layout::TILE),
        ("LEVELS", layout::LEVELS as u32),
        ("FLAG_HISTORY", flags::HISTORY),
        ("FLAG_SURFACE_ID", flags::SURFACE_ID),
        ("FLAG_EMISSION", flags::EMISSION),
        ("FLAG_SAMPLE_COUNT", flags::SAMPLE_COUNT),
        ("FLAG_MOTION_DEPTH", flags::MOTION_DEPTH),
        ("FLAG_MIX", flags::MIX),
        ("FLAG_RING_ERROR", flags::RING_ERROR),
        ("FLAG_INNOVATION", flags::INNOVATION),
        ("FLAG_DEBUG", flags::DEBUG),
        ("FLAG_ERROR", flags::ERROR),
        ("FLAG_LIMITED", flags::LIMITED),
        ("FLAG_SPLIT", flags::SPLIT),
        ("FLAG_SPECULAR_ALBEDO", flags::SPECULAR_ALBEDO),
        ("FLAG_HIT_DISTANCE", flags::HIT_DISTANCE),
        ("FLAG_ROUGHNESS", flags::ROUGHNESS),
        ("FLAG_DEPTH_HARDWARE", flags::DEPTH_HARDWARE),
        ("FLAG_DEPTH_REVERSED", flags::DEPTH_REVERSED),
        ("FLAG_DEPTH_DISTANCE", flags::DEPTH_DISTANCE),
        ("FLAG_MOTION_FROM_PREVIOUS", flags::MOTION_FROM_PREVIOUS),
        ("FLAG_NORMAL_UNSIGNED", flags::NORMAL_UNSIGNED),
        ("FLAG_NORMAL_OCTAHEDRAL", flags::NORMAL_OCTAHEDRAL),
        ("FLAG_NORMAL_VIEW", flags::NORMAL_VIEW),
        ("FLAG_NORMAL_MIRRORED", flags::NORMAL_MIRRORED),
        ("FLAG_NORMAL_ALONE", flags::NORMAL_ALONE),
        ("FLAG_BILINEAR", flags::BILINEAR),
        ("FLAG_SPARSE", flags::SPARSE),
    ];
    for (name, value) in expected {
        assert_eq!(constant(&module, name), value, "{name}");
    }
    let flags: Vec<&str> = (module.constants.iter())
        .filter_map(|(_, c)| c.name.as_deref())
        .filter(|name| name.starts_with("FLAG_"))
        .collect();
    assert!(flags.iter().all(|name| expected.iter().any(|(known, _)| known == name)), "{flags:?}");
}

/// The sizes that follow from the number of features, once for each kind of model.
#[test]
fn columns_match_the_wgsl() {
    let check = |include: &str, columns: Columns, prefix: &str, others: &[(&str, u32)]| {
        let bound = "var<uniform> frame: Frame;";
        let own = format!("\n@group(0) @binding(0) {bound}\nconst OWN_FEATURES = {prefix}_OWN_FEATURES;");
        let module = reflect(&format!("frame numbers surface features linear_model {include}{own}"));
        let expected = [
            ("SURFACE_FEATURES", layout::SURFACE_FEATURES),
            ("FEATURES", columns.features),
            ("COLUMNS", columns.columns()),
            ("SQUARES", columns.squares()),
            ("TILE_STRIDE", columns.tile_stride() / 4),
            ("MODEL_STRIDE", layout::MODEL_STRIDE / 4),
        ];
        for (name, value) in expected.iter().chain(others) {
            assert_eq!(constant(&module, name), *value, "{include}: {name}");
        }
    };
    let of_models = [
        ("LEVEL_WORDS", layout::LEVEL_WORDS),
        ("COVERAGE_ONE", layout::COVERAGE_ONE),
        ("BUCKETS", layout::BUCKETS),
    ];
    check("models", layout::MODELS, "MODEL", &of_models);
    let of_innovations = [("INNOVATION_TILES", layout::INNOVATION_TILES)];
    check("innovations", layout::INNOVATIONS, "INNOVATION", &of_innovations);
}

#[test]
fn windows_match_the_wgsl() {
    // A type, because constants whose type is open are not reflected.
    let reaches = "const REACHES: array<f32, 4> = WINDOW_REACHES;";
    let source = assemble(quell::passes::fit::DESCRIPTOR.source) + reaches;
    let fit = naga::front::wgsl::parse_str(&source).unwrap();
    let tiles = numbers(&fit, "WINDOW_TILES");
    assert_eq!(tiles, layout::WINDOW_TILES.map(f64::from));
    assert_eq!(numbers(&fit, "MOST_TILES"), [*tiles.last().unwrap()]);
    // The tent of the widest window ends where the window does.
    let reaches = numbers(&fit, "REACHES");
    assert_eq!(reaches.len(), tiles.len());
    assert_eq!(2.0 * reaches.last().unwrap(), f64::from(layout::WIDEST_WINDOW_PX));
    let side = f64::from(2 * constant(&fit, "WIDEST_REACH") + 1);
    assert_eq!(side * f64::from(layout::TILE), f64::from(layout::WIDEST_WINDOW_PX));
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

#[test]
fn suspects_match_the_wgsl() {
    use quell::passes::check::{DESCRIPTOR, SuspectUniforms};
    let module = naga::front::wgsl::parse_str(&assemble(DESCRIPTOR.source)).unwrap();
    let suspects = mirror!(
        SuspectUniforms,
        inverse_current,
        inverse_previous,
        turned_current,
        turned_previous,
        before,
        inverse_eye_delta,
        is_before_known,
        turned_eye_delta,
        pad_0,
        before_eye_delta,
        pad_1,
    );
    assert_eq!(members(&module, "Suspects"), suspects);
}

#[test]
fn statistics_of_the_check_match_the_wgsl() {
    use quell::check::suspicion::{GEOMETRY, LIGHT, MOTION, RATIOS, REFLECTION_WORDS, SLOPE_ONE, STATISTICS};
    let module = naga::front::wgsl::parse_str(&assemble(quell::passes::check::DESCRIPTOR.source)).unwrap();
    let names = |suspicions: &[quell::check::suspicion::Suspicion]| -> Vec<&str> {
        suspicions.iter().map(|suspicion| suspicion.name).collect()
    };
    for names in [names(&GEOMETRY), names(&MOTION), LIGHT.to_vec()] {
        for (i, name) in names.into_iter().enumerate() {
            assert_eq!(constant(&module, name), i as u32, "{name}");
        }
    }
    let counts = [
        ("GEOMETRY_SUSPICIONS", GEOMETRY.len()),
        ("MOTION_SUSPICIONS", MOTION.len()),
        ("LIGHT_WORDS", LIGHT.len()),
        ("RATIOS", RATIOS),
    ];
    for (name, count) in counts {
        assert_eq!(constant(&module, name), count as u32, "{name}");
    }
    assert_eq!(numbers(&module, "SLOPE_ONE"), [SLOPE_ONE]);
    let words =
        module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some("tallies")).unwrap().1.ty;
    let naga::TypeInner::Array { size: naga::ArraySize::Constant(words), .. } = module.types[words].inner
    else {
        panic!("no array of a known size");
    };
    assert_eq!(words.get() as usize, STATISTICS);
    assert_eq!(REFLECTION_WORDS, RATIOS + 2);
}
