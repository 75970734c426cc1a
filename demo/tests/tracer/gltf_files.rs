//! glTF files, whole and broken.

use glam::Vec3;
use quell_demo::scene::{Scene, gltf};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A triangle that moves 2 along x in a second, and a lamp.
const TRIANGLE: &str = r#"{
  "asset": {"version": "2.0"},
  "extensionsUsed": ["KHR_texture_transform", "KHR_materials_emissive_strength", "KHR_lights_punctual"],
  "scene": 0, "scenes": [{"nodes": [0, 1]}],
  "nodes": [{"name": "mover", "mesh": 0}, {"extensions": {"KHR_lights_punctual": {"light": 0}}}],
  "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 5, "color": [1, 0.5, 0]}]}},
  "meshes": [{"name": "tri", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
  "materials": [{"emissiveFactor": [0.5, 0.5, 0.5], "alphaMode": "MASK", "alphaCutoff": 0.3,
    "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}}],
  "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
    "samplers": [{"input": 2, "output": 3, "interpolation": "LINEAR"}]}],
  "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
    {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
    {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
    {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}],
  "bufferViews": [
    {"buffer": 0, "byteOffset": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6},
    {"buffer": 0, "byteOffset": 44, "byteLength": 8}, {"buffer": 0, "byteOffset": 52, "byteLength": 24}],
  "buffers": [{"uri": "tri%20angle.bin", "byteLength": 76}]
}"#;

fn triangle_bytes(indices: [u16; 3]) -> Vec<u8> {
    let mut bytes: Vec<u8> = Vec::new();
    let floats = |bytes: &mut Vec<u8>, values: &[f32]| {
        values.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    };
    floats(&mut bytes, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    indices.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    bytes.extend([0, 0]);
    floats(&mut bytes, &[0.0, 1.0]);
    floats(&mut bytes, &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    bytes
}

struct Files {
    folder: TempDir,
}

impl Files {
    fn new(json: &str, bytes: Option<&[u8]>) -> Self {
        let folder = TempDir::new().expect("a temporary folder");
        std::fs::write(folder.path().join("scene.gltf"), json).expect("writes");
        if let Some(bytes) = bytes {
            std::fs::write(folder.path().join("tri angle.bin"), bytes).expect("writes");
        }
        Self { folder }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("scene.gltf")
    }

    fn load(&self) -> Result<Scene, gltf::LoadError> {
        gltf::load(&self.path())
    }
}

/// The message of a refusal, which must name the file and all of `parts`.
fn refused(result: Result<Scene, gltf::LoadError>, path: &Path, parts: &[&str]) {
    let message = result.expect_err("a broken file must be refused").to_string();
    assert!(message.contains(&path.display().to_string()), "no file name in: {message}");
    for part in parts {
        assert!(message.contains(part), "no {part:?} in: {message}");
    }
}

fn refused_json(json: &str, parts: &[&str]) {
    let files = Files::new(json, Some(&triangle_bytes([0, 1, 2])));
    refused(files.load(), &files.path(), parts);
}

#[test]
fn a_whole_file_loads() {
    let scene = Files::new(TRIANGLE, Some(&triangle_bytes([0, 1, 2]))).load().expect("it is valid");
    assert_eq!(scene.instances.len(), 1);
    let node = scene.instances[0].node;
    let place = |time| Vec3::from(scene.pose(time).world_from_node[node].translation);
    assert!(place(0.25).abs_diff_eq(Vec3::X * 0.5, 1e-6));
    // The animation repeats.
    assert!(place(1.5).abs_diff_eq(Vec3::X, 1e-6));
    let material = &scene.materials[scene.meshes[scene.instances[0].mesh].material];
    assert_eq!(material.emissive, [2.0; 3]);
    assert_eq!(material.alpha_cutoff, Some(0.3));
    assert_eq!(scene.punctual_lights[0].intensity, Vec3::new(5.0, 2.5, 0.0));
    assert_eq!(scene.sun, None);
    let normals: Vec<Vec3> = scene.meshes[0].vertices.iter().map(|v| v.normal).collect();
    assert_eq!(normals, [Vec3::Z; 3]);
}

#[test]
fn a_missing_file_is_named() {
    let path = Path::new("/nowhere/scene.glb");
    refused(gltf::load(path), path, &["cannot be read"]);
}

#[test]
fn a_missing_buffer_is_named() {
    let files = Files::new(TRIANGLE, None);
    refused(files.load(), &files.path(), &["buffer 0", "tri angle.bin"]);
}

#[test]
fn a_truncated_buffer_is_named() {
    let files = Files::new(TRIANGLE, Some(&triangle_bytes([0, 1, 2])[..50]));
    refused(files.load(), &files.path(), &["buffer 0", "50 bytes, 76"]);
}

#[test]
fn a_vertex_index_out_of_range_is_named() {
    let files = Files::new(TRIANGLE, Some(&triangle_bytes([0, 1, 7])));
    refused(files.load(), &files.path(), &["mesh 0 (tri), primitive 0", "index 7", "3 vertices"]);
}

#[test]
fn wrong_references_and_types_are_named() {
    refused_json(
        &TRIANGLE.replace(r#""indices": 1"#, r#""indices": 9"#),
        &["meshes[0].primitives[0].indices", "Index out of bounds"],
    );
    refused_json(&TRIANGLE.replace(r#""indices": 1"#, r#""indices": 0"#), &["mesh 0 (tri)", "accessor 0"]);
    refused_json(
        &TRIANGLE.replace(r#""count": 3, "type": "VEC3""#, r#""count": 30, "type": "VEC3""#),
        &["mesh 0 (tri), primitive 0, POSITION", "accessor 0", "do not fit"],
    );
    refused_json(
        &TRIANGLE.replace(r#""byteOffset": 52"#, r#""byteOffset": 4000"#),
        &["animation 0", "buffer view 3"],
    );
}

#[test]
fn a_required_extension_is_named() {
    let json = TRIANGLE
        .replace(r#""scene": 0,"#, r#""extensionsRequired": ["KHR_draco_mesh_compression"], "scene": 0,"#);
    refused_json(&json, &["KHR_draco_mesh_compression"]);
}

#[test]
fn a_cycle_of_nodes_is_refused() {
    let json = TRIANGLE.replace(r#""mesh": 0}, {"#, r#""mesh": 0, "children": [1]}, {"children": [0], "#);
    refused_json(&json, &["node", "twice"]);
}

#[test]
fn an_image_that_cannot_be_decoded_is_named() {
    let json = TRIANGLE
        .replace(r#""buffers":"#, r#""images": [{"name": "wall", "uri": "tri%20angle.bin"}], "buffers":"#);
    refused_json(&json, &["image 0 (wall)", "cannot decode"]);
}

#[test]
fn every_truncation_of_a_glb_is_refused_without_a_panic() {
    let folder = TempDir::new().expect("a temporary folder");
    let path = folder.path().join("scene.glb");
    let mut json = TRIANGLE.replace(r#""uri": "tri%20angle.bin", "#, "").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let bytes = triangle_bytes([0, 1, 2]);
    let mut glb = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + bytes.len();
    [2, total as u32, json.len() as u32].iter().for_each(|v| glb.extend(v.to_le_bytes()));
    glb.extend(b"JSON");
    glb.extend(&json);
    glb.extend((bytes.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(&bytes);
    std::fs::write(&path, &glb).expect("writes");
    gltf::load(&path).expect("the whole file is valid");
    for length in (0..glb.len()).step_by(37) {
        std::fs::write(&path, &glb[..length]).expect("writes");
        refused(gltf::load(&path), &path, &[]);
    }
}
