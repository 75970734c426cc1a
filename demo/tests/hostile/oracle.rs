//! What must hold of whatever is read, or said of what is not.

use crate::harness::Check;
use crate::seeds::{SECRET, SECRET_COLOR};
use quell_demo::capture::Frame;
use quell_demo::scene::Scene;
use quell_demo::tracer::camera_of;
use std::path::Path;

fn ensure(holds: bool, what: impl FnOnce() -> String) -> Check {
    if holds { Ok(()) } else { Err(what()) }
}

/// An error names the file, in a line of its own that fits a screen.
pub fn check_error(error: &str, path: &Path) -> Check {
    ensure(error.contains(&path.display().to_string()), || format!("the error names no file: {error}"))?;
    ensure(!error.chars().any(char::is_control), || format!("the error has control characters: {error:?}"))?;
    ensure(error.len() < 4000, || format!("the error has {} bytes: {:.200}", error.len(), error))
}

/// What the path tracer relies on.
pub fn check_scene(scene: &Scene) -> Check {
    for (i, node) in scene.nodes.iter().enumerate() {
        ensure(node.parent.is_none_or(|parent| parent < i), || format!("node {i} stands before its parent"))?;
    }
    for (i, mesh) in scene.meshes.iter().enumerate() {
        let count = mesh.vertices.len() as u32;
        ensure(mesh.triangles.iter().flatten().all(|&v| v < count), || format!("mesh {i}: a bad index"))?;
        ensure(mesh.material < scene.materials.len(), || format!("mesh {i}: no material"))?;
        for vertex in &mesh.vertices {
            let is_finite = vertex.position.is_finite()
                && vertex.normal.is_finite()
                && vertex.uv.is_finite()
                && vertex.tangent.is_finite();
            ensure(is_finite, || format!("mesh {i}: {vertex:?}"))?;
            ensure(!vertex.position.to_array().contains(&SECRET), || "a buffer from outside".to_owned())?;
        }
    }
    for (i, material) in scene.materials.iter().enumerate() {
        let textures = [material.base_color_texture, material.emissive_texture, material.normal_texture];
        let is_there = textures.into_iter().flatten().all(|texture| texture.image < scene.images.len());
        ensure(is_there, || format!("material {i}: no image"))?;
    }
    for image in &scene.images {
        let texels = image.width as usize * image.height as usize;
        ensure(image.rgba.len() == 4 * texels && texels > 0, || format!("image {} is not full", image.name))?;
        let is_secret = image.rgba.chunks(4).any(|texel| texel[..3] == SECRET_COLOR);
        ensure(!is_secret, || "an image from outside".to_owned())?;
    }
    for instance in &scene.instances {
        let is_there = instance.mesh < scene.meshes.len() && instance.node < scene.nodes.len();
        ensure(is_there, || format!("{instance:?} is of nothing"))?;
    }
    for time in [0.0, 0.25, 1.0, 1.5, 1e6] {
        let pose = scene.pose(time);
        ensure(pose.world_from_node.iter().all(|m| m.is_finite()), || format!("a pose at {time} s"))?;
        let camera = camera_of(&scene.camera(time), 16, 9);
        let is_finite = camera.view_from_world.is_finite() && camera.clip_from_view.is_finite();
        ensure(is_finite, || format!("the camera at {time} s: {:?}", scene.camera(time)))?;
    }
    let (low, high) = scene.bounds();
    ensure(low.is_finite() && high.is_finite() && (high - low).length() > 0.0, || format!("{low}, {high}"))
}

pub fn check_frame(frame: &Frame) -> Check {
    let pixels = frame.width as usize * frame.height as usize;
    let lengths = [frame.radiance.len(), frame.albedo.len(), frame.normal.len(), frame.depth.len()];
    ensure(lengths.iter().all(|&length| length == pixels), || format!("{lengths:?} for {pixels} pixels"))?;
    ensure(!frame.radiance.iter().any(|rgb| rgb[0] == SECRET), || "a frame from outside".to_owned())
}
