//! What of a file is valid but not shown.

use super::element;
use gltf::material::AlphaMode;
use gltf::mesh::Mode;

/// They go to a terminal.
const MOST_NOTES: usize = 100;

/// One line for each element that is shown otherwise than the file asks for.
pub(super) fn left_out(document: &gltf::Document) -> Vec<String> {
    let mut notes = all(document);
    let more = notes.len().saturating_sub(MOST_NOTES);
    if more > 0 {
        notes.truncate(MOST_NOTES);
        notes.push(format!("and {more} more like these"));
    }
    notes
}

fn all(document: &gltf::Document) -> Vec<String> {
    let mut notes = Vec::new();
    for mesh in document.meshes() {
        let what = element("mesh", mesh.index(), mesh.name());
        for primitive in mesh.primitives() {
            if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
                let mode = primitive.mode();
                notes.push(format!("{what}, primitive {}: {mode:?} are not drawn", primitive.index()));
            }
        }
        if mesh.primitives().any(|primitive| primitive.morph_targets().len() > 0) {
            notes.push(format!("{what}: morph targets are ignored"));
        }
    }
    for material in document.materials().filter(|material| material.alpha_mode() == AlphaMode::Blend) {
        let what = element("material", material.index().unwrap_or_default(), material.name());
        notes.push(format!("{what}: blending is drawn as a mask at half"));
    }
    for skin in document.skins() {
        notes.push(format!("{}: drawn without its joints", element("skin", skin.index(), skin.name())));
    }
    for animation in document.animations().skip(1) {
        notes.push(format!(
            "{}: only the first animation plays",
            element("animation", animation.index(), animation.name())
        ));
    }
    notes
}
