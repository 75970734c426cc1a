//! What the path tracer renders: meshes placed by animated nodes, materials, lights and a camera path.
//!
//! Right-handed, y up, metres where the source has units. Colours are linear Rec. 709 radiance or reflectance.

mod animation;
mod camera_path;
pub mod gallery;
pub mod gltf;
mod mesh;
mod texture;
mod tour;

pub use animation::{Interpolation, Node, NodeAnimation, Track, Trs};
pub use camera_path::{CameraPath, CameraPose};
pub use mesh::{Mesh, MeshBuilder, Vertex};
pub use texture::{Image, TextureRef};
pub use tour::{Shown, Tour};

use glam::{Affine3A, Vec3};

/// A scene in world space. Indices in it refer to its own vectors.
#[derive(Debug, Clone)]
pub struct Scene {
    pub name: String,
    pub images: Vec<Image>,
    pub materials: Vec<Material>,
    pub meshes: Vec<Mesh>,
    /// Parents stand before their children.
    pub nodes: Vec<Node>,
    pub instances: Vec<Instance>,
    pub punctual_lights: Vec<PunctualLight>,
    pub sun: Option<Sun>,
    pub sky: Sky,
    pub camera_path: CameraPath,
    /// What of its source the scene does not show, for its user.
    pub notes: Vec<String>,
}

/// A mesh at a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Instance {
    pub mesh: usize,
    pub node: usize,
}

/// A glTF metallic-roughness material.
#[derive(Debug, Clone)]
pub struct Material {
    pub name: String,
    /// Linear, alpha in the last.
    pub base_color: [f32; 4],
    pub base_color_texture: Option<TextureRef>,
    pub metallic: f32,
    /// Linear (perceptual) roughness; the microfacet alpha is its square.
    pub roughness: f32,
    /// Roughness in green, metallic in blue.
    pub metallic_roughness_texture: Option<TextureRef>,
    pub normal_texture: Option<TextureRef>,
    /// Scale of the normal texture's x and y.
    pub normal_scale: f32,
    /// Strength of the dielectric reflection: 1 is an F0 of 0.04, 0 a purely diffuse surface.
    pub specular: f32,
    /// Emitted radiance, strength included.
    pub emissive: [f32; 3],
    pub emissive_texture: Option<TextureRef>,
    /// Scale of the emission over time; a constant 1 where there is none.
    pub emission_scale: Option<Track<f32>>,
    /// Alpha below this is a hole. `None` is opaque.
    pub alpha_cutoff: Option<f32>,
    /// Emits to both sides. (Reflection is two-sided for every material.)
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [0.8, 0.8, 0.8, 1.0],
            base_color_texture: None,
            metallic: 0.0,
            roughness: 0.8,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            specular: 1.0,
            emissive: [0.0; 3],
            emissive_texture: None,
            emission_scale: None,
            alpha_cutoff: None,
            double_sided: false,
        }
    }
}

impl Material {
    pub fn is_emissive(&self) -> bool {
        self.emissive.iter().any(|&e| e > 0.0)
    }
}

/// A distant disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Unit vector towards the sun.
    pub direction: Vec3,
    /// On a surface facing the sun.
    pub irradiance: Vec3,
    /// Half of the disc's angle, in radians; above 0.
    pub angular_radius: f32,
}

/// Radiance from the horizon towards the zenith and the ground, blended by the sine of the elevation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sky {
    pub zenith: Vec3,
    pub horizon: Vec3,
    pub ground: Vec3,
}

impl Sky {
    pub const BLACK: Self = Self::constant(Vec3::ZERO);

    pub const fn constant(radiance: Vec3) -> Self {
        Self { zenith: radiance, horizon: radiance, ground: radiance }
    }
}

/// A light without extent (KHR_lights_punctual) at a node, shining along the node's -z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PunctualLight {
    pub node: usize,
    pub kind: PunctualKind,
    /// Radiant intensity of a point or spot light, irradiance of a directional one.
    pub intensity: Vec3,
    /// Where the light ends; infinite where there is no such limit.
    pub range: f32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PunctualKind {
    Directional,
    Point,
    /// Half angles in radians.
    Spot {
        inner: f32,
        outer: f32,
    },
}

/// The scene's state at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// One per node.
    pub world_from_node: Vec<Affine3A>,
    /// One per material.
    pub emission_scales: Vec<f32>,
}

impl Scene {
    /// A scene with nothing in it but black sky, to be filled.
    pub fn empty(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            images: Vec::new(),
            materials: Vec::new(),
            meshes: Vec::new(),
            nodes: Vec::new(),
            instances: Vec::new(),
            punctual_lights: Vec::new(),
            sun: None,
            sky: Sky::BLACK,
            camera_path: CameraPath::Still(CameraPose {
                eye: Vec3::new(0.0, 0.0, 5.0),
                target: Vec3::ZERO,
                up: Vec3::Y,
                vertical_fov: 0.8,
            }),
            notes: Vec::new(),
        }
    }

    /// Adds a material and returns its index.
    pub fn add_material(&mut self, material: Material) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds an image and returns its index.
    pub fn add_image(&mut self, image: Image) -> usize {
        self.images.push(image);
        self.images.len() - 1
    }

    /// Adds a mesh at a node of its own.
    pub fn add(&mut self, mesh: Mesh, node: Node) -> Instance {
        self.meshes.push(mesh);
        self.nodes.push(node);
        let instance = Instance { mesh: self.meshes.len() - 1, node: self.nodes.len() - 1 };
        self.instances.push(instance);
        instance
    }

    /// Where everything is and how bright it is at `time_s`.
    pub fn pose(&self, time_s: f32) -> Pose {
        let mut world_from_node: Vec<Affine3A> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let local = node.parent_from_node(time_s);
            let world = match node.parent {
                Some(parent) => world_from_node[parent] * local,
                None => local,
            };
            world_from_node.push(world);
        }
        let scale = |m: &Material| m.emission_scale.as_ref().map_or(1.0, |track| track.at(time_s));
        Pose { world_from_node, emission_scales: self.materials.iter().map(scale).collect() }
    }

    /// Which nodes ever move, by themselves or with a parent.
    pub fn animated_nodes(&self) -> Vec<bool> {
        let mut animated: Vec<bool> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            animated.push(node.animation.is_some() || node.parent.is_some_and(|parent| animated[parent]));
        }
        animated
    }

    /// The camera at `time_s` on the scene's path.
    pub fn camera(&self, time_s: f32) -> CameraPose {
        self.camera_path.at(self, time_s)
    }

    /// Corners of the axis-aligned box around all geometry at time 0; a unit cube for an empty scene.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let pose = self.pose(0.0);
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for instance in &self.instances {
            let world = pose.world_from_node[instance.node];
            for vertex in &self.meshes[instance.mesh].vertices {
                let p = world.transform_point3(vertex.position);
                low = low.min(p);
                high = high.max(p);
            }
        }
        if low.x > high.x { (Vec3::splat(-0.5), Vec3::splat(0.5)) } else { (low, high) }
    }
}
