//! Small scenes to trace.

use glam::{Vec3, vec3};
use quell_demo::scene::{
    CameraPose, Interpolation, Material, MeshBuilder, Node, NodeAnimation, Scene, Track, Trs,
};

pub fn look_at(eye: Vec3, target: Vec3, vertical_fov: f32) -> CameraPose {
    CameraPose { eye, target, up: Vec3::Y, vertical_fov }
}

pub fn floor() -> Scene {
    let mut scene = Scene::empty("floor");
    let material = scene.add_material(Material::default());
    let quad = MeshBuilder::new(1.0).quad(vec3(-2.0, 0.0, 1.0), Vec3::X * 4.0, Vec3::NEG_Z * 2.0);
    scene.add(quad.build("floor", material), Node::still(Trs::IDENTITY));
    scene
}

/// A closed grey box with a large lamp under its ceiling and a glossy ball.
pub fn lit_box() -> (Scene, CameraPose) {
    let mut scene = Scene::empty("box");
    let wall = scene.add_material(Material { base_color: [0.6, 0.5, 0.4, 1.0], ..Default::default() });
    let gloss = scene.add_material(Material { roughness: 0.3, metallic: 1.0, ..Default::default() });
    let lamp = scene.add_material(Material { emissive: [3.0; 3], ..Default::default() });
    let room = MeshBuilder::new(1.0).cuboid(Vec3::splat(-1.0), Vec3::ONE);
    scene.add(room.build("room", wall), Node::still(Trs::IDENTITY));
    let ball = MeshBuilder::new(1.0).sphere(vec3(0.3, -0.6, -0.2), 0.4, 24);
    scene.add(ball.build("ball", gloss), Node::still(Trs::IDENTITY));
    // On a node that moves, so that emitters with a transform of their own are covered.
    let panel = MeshBuilder::new(1.0).quad(vec3(-0.6, 0.0, -0.6), Vec3::X * 1.2, Vec3::Z * 1.2);
    scene.add(panel.build("lamp", lamp), Node::spinning(Trs::at(vec3(0.0, 0.9, 0.0)), Vec3::Y, 9.0));
    (scene, look_at(vec3(0.0, 0.0, 0.95), vec3(0.0, -0.1, 0.0), 1.2))
}

/// From one place to another in `seconds`.
pub fn sliding(from: Vec3, to: Vec3, seconds: f32) -> Node {
    let keys = vec![(0.0, from), (seconds, to)];
    let translation = Some(Track { keys, interpolation: Interpolation::Linear, period: seconds });
    let animation = NodeAnimation { translation, ..Default::default() };
    Node { animation: Some(animation), ..Node::still(Trs::IDENTITY) }
}

/// On and off for `seconds` each.
pub fn switch(seconds: f32) -> Track<f32> {
    let keys = vec![(0.0, 1.0), (seconds, 0.0)];
    Track { keys, interpolation: Interpolation::Step, period: 2.0 * seconds }
}
