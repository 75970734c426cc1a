//! Writes a glTF file of glossy things of all kinds, under a camera that goes round them: 4 s one way, 4 s back.
//!
//! `cargo run --release -p quell-demo --example glossy_gltf -- glossy.glb`

mod glb;

use anyhow::Context;
use glam::{Affine3A, Quat, Vec2, Vec3, vec3};
use quell_demo::scene::{
    CameraPath, Image, Interpolation, Material, MeshBuilder, Node, NodeAnimation, Scene, TextureRef, Track,
    Trs,
};
use std::f32::consts::FRAC_PI_2;

const HALF_SIZE: f32 = 4.5;
const HEIGHT: f32 = 3.4;

fn main() -> anyhow::Result<()> {
    let path = std::env::args().nth(1).context("usage: glossy_gltf FILE.glb")?;
    let mut scene = Scene::empty("glossy");
    room(&mut scene);
    balls(&mut scene);
    knot(&mut scene);
    rods(&mut scene);
    lamps(&mut scene);
    camera(&mut scene);
    std::fs::write(&path, glb::glb(&scene)?).with_context(|| format!("cannot write {path}"))
}

fn add(scene: &mut Scene, name: &str, builder: MeshBuilder, material: Material) {
    let material = scene.add_material(Material { name: name.to_owned(), ..material });
    scene.add(builder.build(name, material), Node::still(Trs::IDENTITY));
}

fn dielectric(color: [f32; 3], roughness: f32) -> Material {
    Material { base_color: [color[0], color[1], color[2], 1.0], roughness, ..Default::default() }
}

fn metal(color: [f32; 3], roughness: f32) -> Material {
    Material { metallic: 1.0, ..dielectric(color, roughness) }
}

fn room(scene: &mut Scene) {
    let (s, h) = (HALF_SIZE, HEIGHT);
    let color = scene.add_image(floor_color());
    let roughness = scene.add_image(floor_roughness());
    let floor = Material {
        base_color_texture: Some(TextureRef::new(color)),
        metallic_roughness_texture: Some(TextureRef::new(roughness)),
        ..dielectric([1.0; 3], 1.0)
    };
    let quad = |corner, u, v| MeshBuilder::new(1.0).quad(corner, u, v);
    add(scene, "floor", quad(vec3(-s, 0.0, s), Vec3::X * 2.0 * s, Vec3::NEG_Z * 2.0 * s), floor);
    let (across, up) = (2.0 * s, Vec3::Y * h);
    let orange = dielectric([0.75, 0.30, 0.08], 0.9);
    add(scene, "orange wall", quad(vec3(-s, 0.0, -s), Vec3::X * across, up), orange);
    let teal = dielectric([0.06, 0.38, 0.40], 0.9);
    add(scene, "teal wall", quad(vec3(-s, 0.0, s), Vec3::NEG_Z * across, up), teal.clone());
    add(scene, "other teal wall", quad(vec3(s, 0.0, -s), Vec3::Z * across, up), teal);
    let grey = dielectric([0.5, 0.48, 0.45], 0.9);
    add(scene, "grey wall", quad(vec3(s, 0.0, s), Vec3::NEG_X * across, up), grey.clone());
    add(scene, "ceiling", quad(vec3(-s, h, -s), Vec3::X * across, Vec3::Z * across), grey);
}

const TILES: f32 = 2.0;

fn is_grout(uv: Vec2) -> bool {
    let within = (uv * TILES).fract();
    within.min(1.0 - within).min_element() < 0.012
}

fn tile(uv: Vec2) -> f32 {
    let cell = (uv * TILES).floor();
    (cell.x + 2.0 * cell.y) / 3.0
}

/// Two by two tiles a metre, sRGB: nearly black, each a little different, with light grout.
fn floor_color() -> Image {
    Image::from_fn("floor", 512, |uv| {
        let v = if is_grout(uv) { 150 } else { 46 + (8.0 * tile(uv)) as u8 };
        [v, v, v, 255]
    })
}

/// Roughness in green: 0.1 to 0.2 from tile to tile.
fn floor_roughness() -> Image {
    Image::from_fn("floor roughness", 512, |uv| {
        let roughness = if is_grout(uv) { 0.8 } else { 0.1 + 0.1 * tile(uv) };
        [255, (roughness * 255.0) as u8, 0, 255]
    })
}

fn balls(scene: &mut Scene) {
    let ball = |x: f32, z: f32, radius: f32| MeshBuilder::new(1.0).sphere(vec3(x, radius, z), radius, 48);
    add(scene, "chrome", ball(-0.95, 0.15, 0.55), metal([0.80, 0.81, 0.83], 0.03));
    add(scene, "copper", ball(1.45, 0.45, 0.36), metal([0.93, 0.55, 0.42], 0.45));
    add(scene, "red", ball(-0.15, 1.25, 0.26), dielectric([0.65, 0.04, 0.03], 0.1));
    add(scene, "blue", ball(0.75, 1.35, 0.20), dielectric([0.04, 0.12, 0.55], 0.2));
    add(scene, "green", ball(-1.15, 1.35, 0.22), dielectric([0.05, 0.35, 0.08], 0.3));
    add(scene, "white", ball(-1.95, 0.65, 0.30), dielectric([0.8, 0.78, 0.72], 0.15));
}

/// A gold trefoil.
fn knot(scene: &mut Scene) {
    let stand =
        Affine3A::from_rotation_translation(Quat::from_rotation_x(FRAC_PI_2), vec3(0.45, 0.58, -0.15));
    let tube = MeshBuilder::new(1.0).trefoil().transformed(stand);
    add(scene, "gold knot", tube, metal([0.95, 0.70, 0.32], 0.2));
}

/// Thin things before a bright panel.
fn rods(scene: &mut Scene) {
    let panel = MeshBuilder::new(1.0).quad(vec3(-1.1, 0.5, -2.6), Vec3::X * 2.2, Vec3::Y * 1.3);
    add(scene, "panel", panel, Material { emissive: [3.2, 3.0, 2.7], ..dielectric([0.5; 3], 0.8) });
    let back = MeshBuilder::new(1.0).cuboid(vec3(-1.2, 0.0, -2.75), vec3(1.2, 1.9, -2.61));
    add(scene, "panel's back", back, dielectric([0.1; 3], 0.6));
    let colors = [[0.7, 0.05, 0.05], [0.7, 0.5, 0.05], [0.05, 0.5, 0.1], [0.05, 0.2, 0.7], [0.5, 0.05, 0.5]];
    for (i, color) in colors.into_iter().enumerate() {
        let rod = [(0.0, 0.0), (0.018, 0.0), (0.018, 0.0), (0.018, 1.9), (0.018, 1.9), (0.0, 1.9)];
        let place = vec3(-0.8 + 0.4 * i as f32, 0.0, -2.1);
        let rod = MeshBuilder::new(1.0).lathe(place, &rod, 16);
        add(scene, &format!("rod {i}"), rod, dielectric(color, 0.2));
    }
    let upright =
        Affine3A::from_rotation_translation(Quat::from_rotation_x(FRAC_PI_2), vec3(0.0, 1.15, -1.9));
    let ring = MeshBuilder::new(1.0).torus(Vec3::ZERO, 0.42, 0.015, 96).transformed(upright);
    add(scene, "ring", ring, metal([0.62, 0.63, 0.65], 0.25));
}

fn lamps(scene: &mut Scene) {
    let lamp = |x, y, z, radius| MeshBuilder::new(1.0).sphere(vec3(x, y, z), radius, 10);
    let glow = |r: f32, g: f32, b: f32| Material { emissive: [r, g, b], ..dielectric([0.5; 3], 0.8) };
    add(scene, "warm lamp", lamp(-2.2, 2.5, -1.4, 0.14), glow(110.0, 78.0, 44.0));
    add(scene, "white lamp", lamp(2.4, 2.7, 0.4, 0.12), glow(120.0, 116.0, 106.0));
    add(scene, "cool lamp", lamp(-1.2, 2.8, 2.6, 0.12), glow(76.0, 98.0, 130.0));
    add(scene, "small lamp", lamp(1.0, 0.06, 0.95, 0.06), glow(50.0, 22.0, 6.0));
}

fn camera(scene: &mut Scene) {
    const REACH: f32 = 0.8;
    let key = |time_s, angle| (time_s, Quat::from_rotation_y(angle));
    let rotation = Track {
        keys: vec![key(0.0, -REACH), key(4.0, REACH), key(8.0, -REACH)],
        interpolation: Interpolation::Linear,
        period: 8.0,
    };
    let animation = Some(NodeAnimation { rotation: Some(rotation), ..Default::default() });
    scene.nodes.push(Node { name: "orbit".into(), animation, ..Node::still(Trs::IDENTITY) });
    let orbit = scene.nodes.len() - 1;
    let place = Trs { rotation: Quat::from_rotation_x(-0.22), ..Trs::at(vec3(0.0, 1.45, 4.0)) };
    scene.nodes.push(Node { name: "camera".into(), parent: Some(orbit), ..Node::still(place) });
    scene.camera_path = CameraPath::Node { node: scene.nodes.len() - 1, vertical_fov: 0.75, distance: 4.0 };
}
