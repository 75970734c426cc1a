//! glTF 2.0 files as scenes.
//!
//! One set of texture coordinates per mesh (that of the base colour), repeating textures, rigid and scaled nodes;
//! skins, morph targets, blended transparency and primitives other than triangles are left out, and noted in the scene.

mod animation;
mod defaults;
mod error;
mod extent;
mod images;
mod left_out;
mod lights;
mod limits;
mod material;
mod mesh;
mod read;
mod source;

pub use error::LoadError;

use super::{Instance, Node, Scene, Trs};
use crate::input_file::printable;
use error::fail;
use glam::{Quat, Vec3};
use limits::MOST_TRIANGLES;
use read::File;
use std::path::Path;

type Result<T> = std::result::Result<T, LoadError>;

/// Loads a `.gltf` or `.glb` file. What the file leaves open gets defaults: a sun and a sky where it has no
/// light, a camera path through or around it where it has no camera.
///
/// # Errors
/// [`LoadError`] names the file, the element and the reason. Broken files never panic.
pub fn load(path: &Path) -> Result<Scene> {
    let file = File::open(path)?;
    let name = path.file_stem().map_or_else(|| "scene".into(), |s| s.to_string_lossy());
    let mut scene = Scene::empty(&name);
    scene.images = images::load(&file)?;
    scene.materials = file.document.materials().map(|m| material::load(&file, &m)).collect::<Result<_>>()?;
    let default_material =
        scene.add_material(super::Material { name: "default".into(), ..Default::default() });

    let mut primitives: Vec<Vec<usize>> = Vec::new();
    for mesh in file.document.meshes() {
        let mut indices = Vec::new();
        for primitive in mesh.primitives() {
            if let Some(loaded) = mesh::load(&file, &mesh, &primitive, default_material)? {
                indices.push(scene.meshes.len());
                scene.meshes.push(loaded);
            }
        }
        primitives.push(indices);
    }

    let placed = place_nodes(&file, &mut scene)?;
    let triangles: Vec<usize> = scene.meshes.iter().map(|mesh| mesh.triangles.len()).collect();
    let mut shown = 0;
    for (document_node, &node) in placed.iter() {
        let Some(mesh) = document_node.mesh() else {
            continue;
        };
        for &mesh in &primitives[mesh.index()] {
            shown += triangles[mesh];
            if shown > MOST_TRIANGLES {
                let what = element("node", document_node.index(), document_node.name());
                let reason = format!("with its mesh the scene shows more than {MOST_TRIANGLES} triangles");
                return fail(path, &what, reason);
            }
            scene.instances.push(Instance { mesh, node });
        }
    }
    animation::load(&file, &mut scene, &placed)?;
    lights::load(&file, &mut scene, &placed)?;
    if scene.instances.is_empty() {
        return fail(path, "scene", "it places no mesh that could be shown");
    }
    extent::check(&file, &scene, &placed)?;
    defaults::complete(&mut scene, &placed);
    scene.notes = left_out::left_out(&file.document);
    Ok(scene)
}

/// Nodes of the scene in the order of `Scene::nodes`.
struct Placed<'a> {
    nodes: Vec<(gltf::Node<'a>, usize)>,
    /// By the index in the document; `None` where the scene leaves a node out.
    by_document_index: Vec<Option<usize>>,
}

impl<'a> Placed<'a> {
    fn iter(&self) -> impl Iterator<Item = (&gltf::Node<'a>, &usize)> {
        self.nodes.iter().map(|(node, index)| (node, index))
    }

    fn find(&self, document_index: usize) -> Option<usize> {
        self.by_document_index.get(document_index).copied().flatten()
    }
}

/// Adds the nodes of the default scene (or the first, or of none all roots), parents first.
fn place_nodes<'a>(file: &'a File, scene: &mut Scene) -> Result<Placed<'a>> {
    let document = &file.document;
    let roots: Vec<gltf::Node<'a>> = match document.default_scene().or_else(|| document.scenes().next()) {
        Some(chosen) => chosen.nodes().collect(),
        None => {
            let mut is_child = vec![false; document.nodes().len()];
            document.nodes().flat_map(|n| n.children()).for_each(|child| is_child[child.index()] = true);
            document.nodes().filter(|n| !is_child[n.index()]).collect()
        }
    };
    let mut placed = Placed { nodes: Vec::new(), by_document_index: vec![None; document.nodes().len()] };
    let mut open: Vec<(gltf::Node<'a>, Option<usize>)> = roots.into_iter().map(|n| (n, None)).collect();
    while let Some((node, parent)) = open.pop() {
        let what = element("node", node.index(), node.name());
        if placed.by_document_index[node.index()].is_some() {
            return fail(&file.path, &what, "it is reached twice: nodes must form a tree");
        }
        let (translation, rotation, scale) = node.transform().decomposed();
        let local = Trs {
            translation: Vec3::from(translation),
            rotation: Quat::from_array(rotation).normalize(),
            scale: Vec3::from(scale),
        };
        if !(local.translation.is_finite() && local.rotation.is_finite() && local.scale.is_finite()) {
            let reason = "its transform is no finite translation, rotation and scale";
            return fail(&file.path, &what, reason);
        }
        let name = node.name().unwrap_or_default().to_owned();
        scene.nodes.push(Node { name, parent, ..Node::still(local) });
        let index = scene.nodes.len() - 1;
        open.extend(node.children().map(|child| (child, Some(index))));
        placed.by_document_index[node.index()] = Some(index);
        placed.nodes.push((node, index));
    }
    Ok(placed)
}

/// Of names and paths in messages.
const MOST_NAME_LETTERS: usize = 120;

/// `mesh 3 (Roof)`.
fn element(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) => format!("{kind} {index} ({})", printable(name, MOST_NAME_LETTERS)),
        None => format!("{kind} {index}"),
    }
}
