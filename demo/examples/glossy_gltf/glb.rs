//! Scenes as GLB files.

use anyhow::Context;
use quell_demo::scene::{CameraPath, Image, Material, Mesh, NodeAnimation, Scene, TextureRef};
use serde_json::{Value, json};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// The scene's surfaces, node animations and, where its path is a node's, its camera. Sun, sky and changing emission
/// have no place in the format.
pub fn glb(scene: &Scene) -> anyhow::Result<Vec<u8>> {
    let mut binary = Binary::default();
    let images = scene.images.iter().map(|image| binary.image(image)).collect::<anyhow::Result<Vec<_>>>()?;
    let meshes: Vec<Value> = scene.meshes.iter().map(|mesh| binary.mesh(mesh)).collect();
    let mut nodes: Vec<Value> = scene
        .nodes
        .iter()
        .map(|node| {
            let local = node.local;
            json!({
                "name": node.name, "translation": local.translation.to_array(),
                "rotation": local.rotation.to_array(), "scale": local.scale.to_array(),
            })
        })
        .collect();
    let mut roots = Vec::new();
    for (i, node) in scene.nodes.iter().enumerate() {
        match node.parent {
            Some(parent) => push(&mut nodes[parent]["children"], json!(i)),
            None => roots.push(i),
        }
    }
    for instance in &scene.instances {
        nodes[instance.node]["mesh"] = json!(instance.mesh);
    }
    let mut cameras = Vec::new();
    if let CameraPath::Node { node, vertical_fov, .. } = scene.camera_path {
        cameras.push(json!({"type": "perspective", "perspective": {"yfov": vertical_fov, "znear": 0.01}}));
        nodes[node]["camera"] = json!(0);
    }
    let mut animation = json!({"samplers": [], "channels": []});
    for (i, node) in scene.nodes.iter().enumerate() {
        if let Some(tracks) = &node.animation {
            binary.animate(&mut animation, i, tracks);
        }
    }
    let textures: Vec<Value> = (0..images.len()).map(|source| json!({"source": source})).collect();
    let document = json!({
        "asset": {"version": "2.0", "generator": "quell glossy_gltf"},
        "extensionsUsed": ["KHR_materials_emissive_strength", "KHR_texture_transform"],
        "scene": 0, "scenes": [{"nodes": roots}], "nodes": nodes, "cameras": cameras,
        "meshes": meshes, "materials": scene.materials.iter().map(material).collect::<Vec<_>>(),
        "images": images, "textures": textures, "animations": [animation],
        "accessors": binary.accessors, "bufferViews": binary.views,
        "buffers": [{"byteLength": binary.bytes.len()}],
    });
    container(document.to_string().into_bytes(), binary.bytes)
}

fn push(array: &mut Value, value: Value) {
    match array {
        Value::Array(values) => values.push(value),
        other => *other = json!([value]),
    }
}

/// Header, JSON chunk, binary chunk; all little-endian.
fn container(mut json: Vec<u8>, binary: Vec<u8>) -> anyhow::Result<Vec<u8>> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = u32::try_from(12 + 8 + json.len() + 8 + binary.len()).context("too large for a GLB file")?;
    let mut file = Vec::new();
    file.extend(b"glTF");
    file.extend([2, length].iter().flat_map(|v| v.to_le_bytes()));
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    Ok(file)
}

fn material(material: &Material) -> Value {
    let strength = material.emissive.iter().copied().fold(0.0, f32::max);
    let mut pbr = json!({
        "baseColorFactor": material.base_color,
        "metallicFactor": material.metallic, "roughnessFactor": material.roughness,
    });
    let textures = [
        ("baseColorTexture", material.base_color_texture),
        ("metallicRoughnessTexture", material.metallic_roughness_texture),
    ];
    for (slot, texture) in textures {
        if let Some(texture) = texture {
            pbr[slot] = texture_info(texture);
        }
    }
    let mut value = json!({"name": material.name, "pbrMetallicRoughness": pbr});
    if let Some(texture) = material.normal_texture {
        value["normalTexture"] = texture_info(texture);
    }
    if strength > 0.0 {
        value["emissiveFactor"] = json!(material.emissive.map(|e| e / strength));
        value["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": strength}});
    }
    value
}

fn texture_info(texture: TextureRef) -> Value {
    let transform = json!({
        "offset": texture.offset.to_array(), "rotation": texture.rotation, "scale": texture.scale.to_array(),
    });
    json!({"index": texture.image, "extensions": {"KHR_texture_transform": transform}})
}

/// The binary chunk and what the document says of it.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Binary {
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.views.push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn floats<const N: usize>(&mut self, values: impl Iterator<Item = [f32; N]>) -> usize {
        let values: Vec<[f32; N]> = values.collect();
        let fold = |pick: fn(f32, f32) -> f32| {
            let bound = values.iter().copied().reduce(|a, b| std::array::from_fn(|i| pick(a[i], b[i])));
            bound.map(|bound| bound.to_vec())
        };
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        // Positions and key times need their bounds, all others may have them.
        let (min, max) = (fold(f32::min), fold(f32::max));
        let view = self.view(bytemuck::cast_slice(values.as_flattened()));
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind,
            "min": min, "max": max,
        }));
        self.accessors.len() - 1
    }

    fn mesh(&mut self, mesh: &Mesh) -> Value {
        let attributes = json!({
            "POSITION": self.floats(mesh.vertices.iter().map(|v| v.position.to_array())),
            "NORMAL": self.floats(mesh.vertices.iter().map(|v| v.normal.to_array())),
            "TANGENT": self.floats(mesh.vertices.iter().map(|v| v.tangent.to_array())),
            "TEXCOORD_0": self.floats(mesh.vertices.iter().map(|v| v.uv.to_array())),
        });
        let view = self.view(bytemuck::cast_slice(mesh.triangles.as_flattened()));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": 3 * mesh.triangles.len(),
            "type": "SCALAR",
        }));
        let indices = self.accessors.len() - 1;
        let primitive = json!({"attributes": attributes, "indices": indices, "material": mesh.material});
        json!({"name": mesh.name, "primitives": [primitive]})
    }

    fn image(&mut self, image: &Image) -> anyhow::Result<Value> {
        let pixels = image::RgbaImage::from_raw(image.width, image.height, image.rgba.clone())
            .context("an image's size does not fit its texels")?;
        let mut png = std::io::Cursor::new(Vec::new());
        pixels.write_to(&mut png, image::ImageFormat::Png)?;
        let view = self.view(png.get_ref());
        Ok(json!({"name": image.name, "mimeType": "image/png", "bufferView": view}))
    }

    fn animate(&mut self, animation: &mut Value, node: usize, tracks: &NodeAnimation) {
        let mut add = |path: &str, input: usize, output: usize| {
            let sampler = animation["samplers"].as_array().map_or(0, Vec::len);
            push(&mut animation["samplers"], json!({"input": input, "output": output}));
            let target = json!({"node": node, "path": path});
            push(&mut animation["channels"], json!({"sampler": sampler, "target": target}));
        };
        if let Some(track) = &tracks.translation {
            let times = self.floats(track.keys.iter().map(|key| [key.0]));
            add("translation", times, self.floats(track.keys.iter().map(|key| key.1.to_array())));
        }
        if let Some(track) = &tracks.rotation {
            let times = self.floats(track.keys.iter().map(|key| [key.0]));
            add("rotation", times, self.floats(track.keys.iter().map(|key| key.1.to_array())));
        }
    }
}
