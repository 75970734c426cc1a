//! Meshes and their BVHs as texels.

use crate::scene::{Mesh, Scene};
use anyhow::{Result, ensure};
use glam::{Affine3A, Vec3, Vec4};
use obvhs::{BvhBuildParams, bvh2::Bvh2, bvh2::builder::build_bvh2, triangle::Triangle};
use std::collections::HashMap;

/// `STACK_SIZE` of the shaders.
const MAX_DEPTH: usize = 48;
/// Integers are stored as floats, exact to here.
const MAX_INDEX: usize = 1 << 24;

/// The texels that never change, and what is needed to place them.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub nodes: Vec<Vec4>,
    pub triangles: Vec<Vec4>,
    pub corners: Vec<Vec4>,
    pub placed: Vec<Placed>,
    pub emitters: Vec<Emitter>,
}

/// A BVH with a transform of its own.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    /// Root node.
    pub root: usize,
    /// `None` for the one that holds everything that never moves, in world space.
    pub node: Option<usize>,
    /// Added to its triangles' surface ids.
    pub surface_base: usize,
}

/// A triangle that emits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Emitter {
    pub triangle: usize,
    /// Index into `Geometry::placed`.
    pub placed: usize,
    pub material: usize,
    /// In the space of `placed`.
    pub edges: [Vec3; 2],
}

/// A triangle on its way into a BVH.
struct Soup {
    corners: [crate::scene::Vertex; 3],
    material: usize,
    surface: usize,
}

impl Geometry {
    pub fn new(scene: &Scene) -> Result<Self> {
        let mut geometry = Self::default();
        let animated = scene.animated_nodes();
        let pose = scene.pose(0.0);
        let mut still = Vec::new();
        for (i, instance) in scene.instances.iter().enumerate() {
            if !animated[instance.node] {
                let world = pose.world_from_node[instance.node];
                collect(&scene.meshes[instance.mesh], world, i + 1, &mut still);
            }
        }
        if !still.is_empty() {
            let (root, first) = geometry.append(scene, &still)?;
            geometry.place(scene, Placed { root, node: None, surface_base: 0 }, first..first + still.len());
        }
        let mut built: HashMap<usize, (usize, std::ops::Range<usize>)> = HashMap::new();
        for (i, instance) in scene.instances.iter().enumerate() {
            let mesh = &scene.meshes[instance.mesh];
            if !animated[instance.node] || mesh.triangles.is_empty() {
                continue;
            }
            let (root, range) = match built.get(&instance.mesh) {
                Some(known) => known.clone(),
                None => {
                    let mut soup = Vec::new();
                    collect(mesh, Affine3A::IDENTITY, 0, &mut soup);
                    let (root, first) = geometry.append(scene, &soup)?;
                    let known = (root, first..first + soup.len());
                    built.insert(instance.mesh, known.clone());
                    known
                }
            };
            geometry.place(scene, Placed { root, node: Some(instance.node), surface_base: i + 1 }, range);
        }
        Ok(geometry)
    }

    fn place(&mut self, scene: &Scene, placed: Placed, triangles: std::ops::Range<usize>) {
        let index = self.placed.len();
        self.placed.push(placed);
        for triangle in triangles {
            let texels = &self.triangles[3 * triangle..3 * triangle + 3];
            let tag = texels[0].w;
            let material = if tag < 0.0 { -1.0 - tag } else { tag } as usize;
            let edges = [texels[1].truncate(), texels[2].truncate()];
            let has_area = edges[0].cross(edges[1]).length_squared() > 0.0;
            if scene.materials[material].is_emissive() && has_area {
                self.emitters.push(Emitter { triangle, placed: index, material, edges });
            }
        }
    }

    /// Builds a BVH and appends it; returns its root node and its first triangle.
    fn append(&mut self, scene: &Scene, soup: &[Soup]) -> Result<(usize, usize)> {
        let bvh = build(soup);
        let depth = bvh.depth(0);
        ensure!(depth <= MAX_DEPTH, "a BVH is {depth} levels deep, at most {MAX_DEPTH} can be traced");
        let root = self.nodes.len() / 2;
        let first = self.triangles.len() / 3;
        ensure!(
            root + bvh.nodes.len() < MAX_INDEX && first + soup.len() < MAX_INDEX,
            "the scene has more than {MAX_INDEX} triangles or BVH nodes"
        );
        for node in &bvh.nodes {
            let base = if node.is_leaf() { first } else { root };
            let child = (base + node.first_index as usize) as f32;
            self.nodes.push(node.aabb().min.extend(node.prim_count as f32));
            self.nodes.push(node.aabb().max.extend(child));
        }
        for &i in &bvh.primitive_indices {
            self.push_triangle(scene, &soup[i as usize]);
        }
        Ok((root, first))
    }

    fn push_triangle(&mut self, scene: &Scene, soup: &Soup) {
        let [a, b, c] = soup.corners;
        let material = soup.material as f32;
        let masked = scene.materials[soup.material].alpha_cutoff.is_some();
        let handedness = a.tangent.w;
        self.triangles.extend([
            a.position.extend(if masked { -1.0 - material } else { material }),
            (b.position - a.position).extend(soup.surface as f32),
            (c.position - a.position).extend(handedness),
        ]);
        self.corners.extend([a, b, c].map(|v| v.normal.extend(v.uv.x)));
        self.corners.extend([a, b, c].map(|v| v.tangent.truncate().extend(v.uv.y)));
    }
}

fn build(soup: &[Soup]) -> Bvh2 {
    let triangle = |t: &Soup| {
        let [a, b, c] = t.corners.map(|v| v.position.into());
        Triangle { v0: a, v1: b, v2: c }
    };
    let triangles: Vec<Triangle> = soup.iter().map(triangle).collect();
    let params = BvhBuildParams { max_prims_per_leaf: 2, ..BvhBuildParams::medium_build() };
    build_bvh2(&triangles, params, &mut Default::default())
}

fn collect(mesh: &Mesh, transform: Affine3A, surface: usize, soup: &mut Vec<Soup>) {
    let normal_from_object = transform.matrix3.inverse().transpose();
    // A reflection turns the winding, which says where the front is.
    let mirrored = transform.matrix3.determinant() < 0.0;
    for &[a, b, c] in &mesh.triangles {
        let order = if mirrored { [a, c, b] } else { [a, b, c] };
        let corners = order.map(|i| {
            let mut vertex = mesh.vertices[i as usize];
            vertex.position = transform.transform_point3(vertex.position);
            vertex.normal = (normal_from_object * vertex.normal).normalize_or(Vec3::Y);
            let tangent = transform.transform_vector3(vertex.tangent.truncate()).normalize_or(Vec3::X);
            let sign = if mirrored { -vertex.tangent.w } else { vertex.tangent.w };
            vertex.tangent = tangent.extend(sign);
            vertex
        });
        soup.push(Soup { corners, material: mesh.material, surface });
    }
}
