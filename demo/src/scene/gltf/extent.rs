//! That everything stays where numbers of 32 bits can tell it apart, at all times.

use super::error::fail;
use super::limits::MOST_DISTANCE;
use super::read::File;
use super::{Placed, Result, element};
use crate::scene::{Node, Scene, Track};
use glam::Vec3;

/// Size of a scene over its distance from the origin: the path tracer lifts rays off surfaces by that much.
const LEAST_RELATIVE_SIZE: f32 = 1e-5;
/// A nanometre; areas of less are lost in products.
const LEAST_SIZE: f32 = 1e-9;

/// How far a node's frame and its scale get at any time, whatever its rotations.
#[derive(Clone, Copy)]
struct Reach {
    offset: f64,
    scale: f64,
}

pub(super) fn check(file: &File, scene: &Scene, placed: &Placed<'_>) -> Result<()> {
    let mut radii = vec![0.0_f64; scene.nodes.len()];
    let radius_of = |mesh: &crate::scene::Mesh| {
        mesh.vertices.iter().map(|v| f64::from(v.position.abs().max_element())).fold(0.0, f64::max)
            * 3_f64.sqrt()
    };
    let mesh_radii: Vec<f64> = scene.meshes.iter().map(radius_of).collect();
    for instance in &scene.instances {
        radii[instance.node] = radii[instance.node].max(mesh_radii[instance.mesh]);
    }
    let mut reaches: Vec<Reach> = Vec::with_capacity(scene.nodes.len());
    for (document_node, &index) in placed.iter() {
        let node = &scene.nodes[index];
        let parent = node.parent.map_or(Reach { offset: 0.0, scale: 1.0 }, |parent| reaches[parent]);
        let reach = Reach {
            offset: parent.offset + parent.scale * farthest_translation(node),
            scale: parent.scale * largest_scale(node),
        };
        let distance = reach.offset + reach.scale * radii[index];
        // Scales of nodes without a mesh count too: a camera's or a light's axes come from them.
        let most = f64::from(MOST_DISTANCE);
        if !(distance <= most && reach.scale <= most) {
            let what = element("node", document_node.index(), document_node.name());
            let reason = format!("it reaches {distance:.1e} from the origin, expected at most {most:.0e}");
            return fail(&file.path, &what, reason);
        }
        reaches.push(reach);
    }
    let (low, high) = scene.bounds();
    let (size, far) = ((high - low).length(), low.abs().max(high.abs()).max_element());
    if size < LEAST_SIZE.max(LEAST_RELATIVE_SIZE * far) {
        let reason =
            format!("all it shows lies within {size:.1e}, at {far:.1e} from the origin: nothing to see");
        return fail(&file.path, "scene", reason);
    }
    Ok(())
}

fn farthest_translation(node: &Node) -> f64 {
    let track = node.animation.as_ref().and_then(|animation| animation.translation.as_ref());
    largest(node.local.translation, track, |v| v.as_dvec3().length())
}

fn largest_scale(node: &Node) -> f64 {
    let track = node.animation.as_ref().and_then(|animation| animation.scale.as_ref());
    largest(node.local.scale, track, |v| f64::from(v.abs().max_element()))
}

fn largest(still: Vec3, track: Option<&Track<Vec3>>, size: impl Fn(Vec3) -> f64) -> f64 {
    track.into_iter().flat_map(|track| &track.keys).map(|&(_, value)| size(value)).fold(size(still), f64::max)
}
