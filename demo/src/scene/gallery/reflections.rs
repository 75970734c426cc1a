//! A room at night that is all reflections: what a denoiser that follows surfaces alone would blur or drag along.
//!
//! What each part is there for: wet floor, reflections of all sharpness under a moving camera; mirror, a second room with motion of
//! its own; row of balls, roughness from mirror to satin; knot, curved metal that turns; lacquered panels, texture under a
//! reflection; lamp and ball on their rounds, light and things that move in mirrors while what mirrors them stands still.

use super::{add_still, textures};
use crate::scene::{
    CameraPath, Interpolation, Material, MeshBuilder, Node, NodeAnimation, Scene, TextureRef, Track, Trs,
};
use glam::{Affine3A, Quat, Vec2, Vec3, vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Seconds of the camera's path.
pub(super) const LENGTH_S: f32 = 12.0;

/// Walls of the room: x and z, low and high.
const X: [f32; 2] = [-5.0, 4.6];
const Z: [f32; 2] = [-3.4, 4.4];
const HEIGHT: f32 = 3.4;

/// The room. Light comes of its lamps alone.
pub(super) fn reflections() -> Scene {
    let mut scene = Scene::empty("reflections");
    shell(&mut scene);
    mirror(&mut scene);
    panels(&mut scene);
    centrepiece(&mut scene);
    ladder(&mut scene);
    brushed(&mut scene);
    lights(&mut scene);
    rounds(&mut scene);
    scene.camera_path = path();
    scene
}

fn dielectric(name: &str, [r, g, b]: [f32; 3], roughness: f32) -> Material {
    Material { name: name.to_owned(), base_color: [r, g, b, 1.0], roughness, ..Default::default() }
}

fn metal(name: &str, color: [f32; 3], roughness: f32) -> Material {
    Material { metallic: 1.0, ..dielectric(name, color, roughness) }
}

fn glow(name: &str, emissive: [f32; 3]) -> Material {
    Material { emissive, ..dielectric(name, [0.6; 3], 0.8) }
}

/// Adds what does not move, in a material of its own.
fn add(scene: &mut Scene, builder: MeshBuilder, material: Material) {
    let name = material.name.clone();
    let material = scene.add_material(material);
    add_still(scene, &name, builder, material);
}

fn shell(scene: &mut Scene) {
    let color = scene.add_image(textures::wet_tiles());
    let roughness = scene.add_image(textures::wet_tiles_roughness());
    let floor = Material {
        base_color_texture: Some(TextureRef::new(color)),
        metallic_roughness_texture: Some(TextureRef::new(roughness)),
        ..dielectric("wet floor", [1.0; 3], 1.0)
    };
    let low = vec3(X[0], 0.0, Z[0]);
    let (x, y, z) = (Vec3::X * (X[1] - X[0]), Vec3::Y * HEIGHT, Vec3::Z * (Z[1] - Z[0]));
    let quad = |corner, u, v| MeshBuilder::new(0.4).quad(corner, u, v);
    add(scene, quad(low + z, x, -z), floor);
    add(scene, quad(low + y, x, z), dielectric("ceiling", [0.30, 0.29, 0.30], 0.9));
    add(scene, quad(low, x, y), dielectric("back wall", [0.50, 0.20, 0.13], 0.85));
    add(scene, quad(low + x + z, -x, y), dielectric("front wall", [0.10, 0.20, 0.26], 0.85));
    add(scene, quad(low + z, -z, y), dielectric("left wall", [0.07, 0.21, 0.24], 0.85));
    add(scene, quad(low + x, z, y), dielectric("right wall", [0.42, 0.33, 0.24], 0.85));
}

/// Flat, on the back wall, in a frame of gold.
fn mirror(scene: &mut Scene) {
    let (low, high) = (vec3(-2.3, 0.55, Z[0]), vec3(2.3, 2.65, Z[0] + 0.04));
    let glass = MeshBuilder::new(1.0).quad(
        vec3(low.x, low.y, high.z),
        Vec3::X * (high.x - low.x),
        Vec3::Y * (high.y - low.y),
    );
    add(scene, glass, metal("mirror", [0.90, 0.92, 0.91], 0.0));
    let (bar, front) = (0.09, Z[0] + 0.10);
    let frame = MeshBuilder::new(1.0)
        .cuboid(vec3(low.x - bar, low.y - bar, low.z), vec3(high.x + bar, low.y, front))
        .cuboid(vec3(low.x - bar, high.y, low.z), vec3(high.x + bar, high.y + bar, front))
        .cuboid(vec3(low.x - bar, low.y, low.z), vec3(low.x, high.y, front))
        .cuboid(vec3(high.x, low.y, low.z), vec3(high.x + bar, high.y, front));
    add(scene, frame, metal("gilt", [0.95, 0.70, 0.32], 0.25));
}

/// Pictures under lacquer, along the left wall and on the front one.
fn panels(scene: &mut Scene) {
    let pictures = [textures::painting_sea(), textures::painting_rings(), textures::painting_fields()];
    let [sea, rings, fields] = pictures.map(|picture| {
        let name = format!("lacquered {}", picture.name);
        let image = scene.add_image(picture);
        let texture = Some(TextureRef::new(image));
        scene.add_material(Material { base_color_texture: texture, ..dielectric(&name, [0.9; 3], 0.08) })
    });
    let size = 1.5;
    let board = dielectric("black lacquer", [0.012, 0.012, 0.014], 0.1);
    let mut boards = MeshBuilder::new(1.0);
    for (z, picture) in [(-1.75, sea), (0.35, rings), (2.45, fields)] {
        let corner = vec3(X[0] + 0.10, 0.75, z + 0.5 * size);
        let canvas = MeshBuilder::default().picture(corner, Vec3::NEG_Z * size, Vec3::Y * size);
        add_still(scene, "panel", canvas, picture);
        let edge = vec3(0.0, 0.06, 0.06);
        let low = vec3(X[0], 0.75, z - 0.5 * size) - edge;
        boards = boards.cuboid(low, vec3(X[0] + 0.095, 0.75 + size, z + 0.5 * size) + edge);
    }
    for (x, picture) in [(-1.5, rings), (1.5, sea)] {
        let corner = vec3(x + 0.5 * size, 0.8, Z[1] - 0.02);
        let canvas = MeshBuilder::default().picture(corner, Vec3::NEG_X * size, Vec3::Y * size);
        add_still(scene, "front panel", canvas, picture);
    }
    add(scene, boards, board);
}

/// A knot of gold that turns on a plinth of lacquer, in a ring of chrome.
fn centrepiece(scene: &mut Scene) {
    let plinth =
        [(0.0, 0.0), (0.62, 0.0), (0.62, 0.0), (0.62, 0.30), (0.60, 0.32), (0.60, 0.32), (0.0, 0.32)];
    let plinth = MeshBuilder::new(1.0).lathe(Vec3::ZERO, &plinth, 64);
    add(scene, plinth, dielectric("plinth", [0.35, 0.015, 0.02], 0.06));
    let upright = Affine3A::from_rotation_x(FRAC_PI_2);
    let knot = MeshBuilder::new(1.0).trefoil().transformed(upright);
    let gold = scene.add_material(metal("gold", [0.95, 0.70, 0.32], 0.2));
    scene.add(knot.build("knot", gold), Node::spinning(Trs::at(vec3(0.0, 0.93, 0.0)), Vec3::Y, LENGTH_S));
    let ring = MeshBuilder::new(1.0).torus(vec3(0.0, 0.05, 0.0), 0.85, 0.05, 128);
    add(scene, ring, metal("chrome", [0.80, 0.81, 0.83], 0.03));
}

/// Balls from mirror to satin.
fn ladder(scene: &mut Scene) {
    let shelf = MeshBuilder::new(1.0).cuboid(vec3(-2.2, 0.0, -2.75), vec3(2.2, 0.34, -2.25));
    add(scene, shelf, dielectric("shelf", [0.03, 0.03, 0.035], 0.15));
    let steps = [
        ("chrome ball", [0.80, 0.81, 0.83], 0.03),
        ("brass ball", [0.89, 0.72, 0.38], 0.12),
        ("rose ball", [0.91, 0.60, 0.50], 0.22),
        ("steel ball", [0.62, 0.63, 0.65], 0.35),
        ("copper ball", [0.93, 0.55, 0.42], 0.5),
    ];
    for (i, (name, color, roughness)) in steps.into_iter().enumerate() {
        let centre = vec3(-1.7 + 0.85 * i as f32, 0.34 + 0.25, -2.5);
        add(scene, MeshBuilder::new(1.0).sphere(centre, 0.25, 40), metal(name, color, roughness));
    }
}

/// Metal that was turned and ground: its roughness runs in streaks.
fn brushed(scene: &mut Scene) {
    let streaks = scene.add_image(textures::streaks());
    let brushed = |name: &str, color| Material {
        metallic_roughness_texture: Some(TextureRef::scaled(streaks, Vec2::new(0.5, 1.0))),
        ..metal(name, color, 0.5)
    };
    let column = [(0.0, 0.0), (0.26, 0.0), (0.26, 0.0), (0.26, HEIGHT), (0.26, HEIGHT), (0.0, HEIGHT)];
    let columns = [vec3(-3.3, 0.0, -2.3), vec3(3.3, 0.0, -2.3)]
        .into_iter()
        .fold(MeshBuilder::new(1.0), |builder, place| builder.lathe(place, &column, 64));
    add(scene, columns, brushed("brushed steel", [0.66, 0.67, 0.70]));
    let slab = MeshBuilder::new(1.0).cuboid(vec3(-0.6, 0.0, -0.03), vec3(0.6, 1.5, 0.03));
    let turn = Affine3A::from_rotation_translation(Quat::from_rotation_y(1.1), vec3(-2.7, 0.0, -0.9));
    add(scene, slab.transformed(turn), brushed("brushed bronze", [0.80, 0.52, 0.33]));
    let vase = [
        (0.0, 0.0),
        (0.16, 0.0),
        (0.20, 0.05),
        (0.30, 0.25),
        (0.32, 0.42),
        (0.25, 0.62),
        (0.12, 0.78),
        (0.09, 0.88),
        (0.13, 0.98),
        (0.11, 0.98),
        (0.07, 0.88),
    ];
    let checker = scene.add_image(textures::checker());
    let vases = [vec3(1.75, 0.0, -1.55), vec3(-3.2, 0.0, 1.6)]
        .into_iter()
        .fold(MeshBuilder::new(1.0), |builder, place| builder.lathe(place, &vase, 56));
    let glaze = Material {
        base_color_texture: Some(TextureRef::new(checker)),
        ..dielectric("glaze", [0.25, 0.55, 0.85], 0.07)
    };
    add(scene, vases, glaze);
}

fn lights(scene: &mut Scene) {
    let (radius, height) = (0.78, 2.3);
    let halo = MeshBuilder::new(1.0).torus(vec3(0.0, height, 0.0), radius, 0.045, 48);
    add(scene, halo, glow("halo", [49.0, 43.0, 34.0]));
    let wires = (0..3).fold(MeshBuilder::new(1.0), |builder, i| {
        let (sin, cos) = (i as f32 / 3.0 * TAU).sin_cos();
        builder.lathe(vec3(radius * cos, height, radius * sin), &[(0.006, 0.0), (0.006, HEIGHT - height)], 8)
    });
    add(scene, wires, metal("wires", [0.20, 0.20, 0.21], 0.4));
    let bars = [-2.85, -0.7, 1.4, 3.5].into_iter().fold(MeshBuilder::new(1.0), |builder, z| {
        builder.cuboid(vec3(X[0], 0.4, z - 0.04), vec3(X[0] + 0.05, 2.7, z + 0.04))
    });
    add(scene, bars, glow("bars", [4.0, 12.0, 15.5]));
    let cove = MeshBuilder::new(1.0).cuboid(vec3(X[1] - 0.05, 2.6, -2.6), vec3(X[1], 2.74, 3.6));
    add(scene, cove, glow("cove", [24.0, 8.3, 4.8]));
}

/// A lamp and a lacquered ball that circle the centrepiece, opposite to each other.
fn rounds(scene: &mut Scene) {
    let lamp = scene.add_material(glow("lamp", [73.0, 49.0, 26.0]));
    let globe = MeshBuilder::new(1.0).sphere(Vec3::ZERO, 0.16, 12).build("lamp", lamp);
    scene.add(globe, circling(vec3(0.0, 1.55, 0.0), 1.55, 0.0, 6.0));
    let lacquer = scene.add_material(dielectric("blue lacquer", [0.03, 0.10, 0.50], 0.1));
    let ball = MeshBuilder::new(1.0).sphere(Vec3::ZERO, 0.22, 32).build("ball", lacquer);
    scene.add(ball, circling(vec3(0.0, 0.22, 0.0), 1.35, 0.5, 6.0));
}

/// A node on a level circle, `phase` turns ahead, once round in `period_s`.
fn circling(centre: Vec3, radius: f32, phase: f32, period_s: f32) -> Node {
    const KEYS: usize = 96;
    let place = |i: usize| {
        let turn = i as f32 / KEYS as f32;
        let (sin, cos) = ((turn + phase) * TAU).sin_cos();
        (turn * period_s, centre + radius * vec3(cos, 0.0, sin))
    };
    let keys = (0..=KEYS).map(place).collect();
    let translation = Some(Track { keys, interpolation: Interpolation::Linear, period: period_s });
    let animation = Some(NodeAnimation { translation, ..Default::default() });
    Node { animation, ..Node::still(Trs::IDENTITY) }
}

/// Along the mirror first, then round the centrepiece.
fn path() -> CameraPath {
    let along = (0..4).map(|i| {
        let x = -2.6 + 1.3 * i as f32;
        (vec3(x, 1.5, 3.3), vec3(0.55 * x, 0.95, -0.6))
    });
    let round = (1..5).map(|i| {
        // From +z towards +x.
        let (sin, cos) = (0.38 + 0.36 * i as f32).sin_cos();
        (vec3(3.55 * sin, 1.5 - 0.05 * i as f32, 3.55 * cos), vec3(-0.15 * i as f32, 0.85, 0.0))
    });
    CameraPath::Spline {
        points: along.chain(round).collect(),
        vertical_fov: 1.0,
        duration: LENGTH_S,
        closed: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lamp_and_the_ball_go_round() {
        let scene = reflections();
        for name in ["lamp", "ball"] {
            let instance = scene.instances.iter().find(|i| scene.meshes[i.mesh].name == name).unwrap();
            let place = |time_s| Vec3::from(scene.pose(time_s).world_from_node[instance.node].translation);
            for second in 0..LENGTH_S as u32 {
                let way = place(second as f32).distance(place(second as f32 + 1.0));
                assert!((1.0..2.5).contains(&way), "{name} at {second} s: {way} m");
            }
        }
    }

    #[test]
    fn all_light_is_of_the_room_and_the_camera_stays_in_it() {
        let scene = reflections();
        assert!(scene.sun.is_none() && scene.punctual_lights.is_empty());
        assert_eq!(scene.sky, crate::scene::Sky::BLACK);
        let (low, high) = scene.bounds();
        for step in 0..=24 {
            let eye = scene.camera(0.5 * step as f32).eye;
            assert!((low + 0.5).cmplt(eye).all() && eye.cmplt(high - 0.5).all(), "{eye}");
            // Nor inside the plinth's ring.
            assert!(eye.with_y(0.0).length() > 1.5, "{eye}");
        }
    }
}
