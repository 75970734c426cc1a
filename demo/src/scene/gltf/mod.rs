//! glTF 2.0 files as scenes.
//!
//! One set of texture coordinates per mesh (that of the base colour), repeating textures, rigid and scaled nodes;
//! skins, morph targets, blended transparency and primitives other than triangles are left out, and noted in the scene.

mod animation;
mod defaults;
mod error;
mod left_out;
mod lights;
mod material;
mod mesh;
mod read;

pub use error::LoadError;

use super::{Instance, Node, Scene, Trs};
use error::fail;
use glam::{Quat, Vec3};
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
    scene.images = file.images()?;
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
    for (document_node, &node) in placed.iter() {
        if let Some(mesh) = document_node.mesh() {
            scene.instances.extend(primitives[mesh.index()].iter().map(|&mesh| Instance { mesh, node }));
        }
    }
    animation::load(&file, &mut scene, &placed)?;
    lights::load(&mut scene, &placed);
    if scene.instances.is_empty() {
        return fail(path, "scene", "it places no mesh that could be shown");
    }
    if !scene.pose(0.0).world_from_node.iter().all(|m| m.is_finite()) {
        return fail(path, "nodes", "a transform is not finite");
    }
    defaults::complete(&mut scene, &placed);
    scene.notes = left_out::left_out(&file.document);
    Ok(scene)
}

/// Nodes of the scene in the order of `Scene::nodes`.
#[derive(Default)]
struct Placed<'a> {
    nodes: Vec<(gltf::Node<'a>, usize)>,
}

impl<'a> Placed<'a> {
    fn iter(&self) -> impl Iterator<Item = (&gltf::Node<'a>, &usize)> {
        self.nodes.iter().map(|(node, index)| (node, index))
    }

    fn find(&self, document_index: usize) -> Option<usize> {
        self.nodes.iter().find(|(node, _)| node.index() == document_index).map(|&(_, index)| index)
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
    let mut placed = Placed::default();
    let mut seen = vec![false; document.nodes().len()];
    let mut open: Vec<(gltf::Node<'a>, Option<usize>)> = roots.into_iter().map(|n| (n, None)).collect();
    while let Some((node, parent)) = open.pop() {
        let what = element("node", node.index(), node.name());
        if std::mem::replace(&mut seen[node.index()], true) {
            return fail(&file.path, &what, "it is reached twice: nodes must form a tree");
        }
        let (translation, rotation, scale) = node.transform().decomposed();
        let local = Trs {
            translation: Vec3::from(translation),
            rotation: Quat::from_array(rotation).normalize(),
            scale: Vec3::from(scale),
        };
        let name = node.name().unwrap_or_default().to_owned();
        scene.nodes.push(Node { name, parent, ..Node::still(local) });
        let index = scene.nodes.len() - 1;
        open.extend(node.children().map(|child| (child, Some(index))));
        placed.nodes.push((node, index));
    }
    Ok(placed)
}

/// `mesh 3 (Roof)`.
fn element(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) => format!("{kind} {index} ({name})"),
        None => format!("{kind} {index}"),
    }
}
