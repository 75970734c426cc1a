//! The default tour, built in code: a walk through the gallery, then a room of reflections (a scene of its own).
//!
//! The gallery is a colonnade in the sun and a hall behind it that only indirect light reaches.
//!
//! What each part is there for: columns, sharp sun shadows under a moving camera; checker floor, glossy
//! reflections; hall, indirect light through doors and a high gap; lamp, light that changes at once; torus and
//! ball, rigid motion; railing and screen, thin geometry and disocclusion; bricks, planks and paintings, texture.
//!
//! x runs along the building, +z is out into the sun. The wall between colonnade and hall is at z = 0.

mod looks;
mod reflections;
mod textures;

use super::{
    CameraPath, Interpolation, Material, MeshBuilder, Node, NodeAnimation, Scene, Sky, Sun, Tour, Track, Trs,
};
use glam::{Affine3A, Quat, Vec3, vec3};
use looks::Looks;
use reflections::reflections;

const HALF_LENGTH: f32 = 9.0;
const DEPTH: f32 = 5.5;
const HEIGHT: f32 = 4.2;
/// Of the wall between; the gap above it lights the hall.
const WALL_HEIGHT: f32 = 3.0;
const WALL: f32 = 0.15;
/// The north wall's lower part; above it light plaster.
const BRICK_HEIGHT: f32 = 2.9;
/// Depth of the roof's slot.
const SLOT: f32 = 0.9;
/// Doors are at plus and minus this x.
const DOOR: f32 = 6.0;
const DOOR_HALF_WIDTH: f32 = 1.05;
/// Seconds of the walk, after which the tour goes on in the room of reflections.
pub const WALK_S: f32 = 24.0;

/// The walk through the gallery, then a room that is all reflections.
pub fn tour() -> Tour {
    Tour::new("gallery", vec![(gallery(), WALK_S), (reflections(), reflections::LENGTH_S)])
}

/// The gallery. Loads nothing; the same on every run.
pub fn gallery() -> Scene {
    let mut scene = Scene::empty("gallery");
    let looks = Looks::new(&mut scene);
    building(&mut scene, &looks);
    colonnade(&mut scene, &looks);
    paintings(&mut scene, &looks);
    exhibits(&mut scene, &looks);
    lamp(&mut scene, &looks);
    screen(&mut scene, &looks);
    garden(&mut scene, &looks);
    scene.sun = Some(Sun {
        direction: vec3(0.42, 0.78, 0.80).normalize(),
        irradiance: vec3(17.0, 15.0, 12.2),
        angular_radius: 0.004_65,
    });
    scene.sky =
        Sky { zenith: vec3(0.55, 0.95, 1.9), horizon: vec3(1.7, 1.95, 2.3), ground: vec3(0.5, 0.45, 0.4) };
    scene.camera_path = walk();
    scene
}

fn add_still(scene: &mut Scene, name: &str, builder: MeshBuilder, material: usize) {
    scene.add(builder.build(name, material), Node::still(Trs::IDENTITY));
}

fn building(scene: &mut Scene, looks: &Looks) {
    let (l, d, h) = (HALF_LENGTH, DEPTH, HEIGHT);
    let floor = |z: f32| MeshBuilder::new(0.5).quad(vec3(-l, 0.0, z + d), Vec3::X * 2.0 * l, Vec3::NEG_Z * d);
    add_still(scene, "checker floor", floor(0.0), looks.checker);
    add_still(scene, "plank floor", floor(-d), looks.wood);
    let ground = MeshBuilder::new(1.0).cuboid(vec3(-60.0, -0.5, -60.0), vec3(60.0, -0.15, 60.0));
    add_still(scene, "ground", ground, looks.ground);
    let steps = MeshBuilder::new(0.5)
        .cuboid(vec3(-l - 0.3, -0.15, -d - 0.3), vec3(l + 0.3, -0.005, d + 0.5))
        .cuboid(vec3(-l - 0.3, -0.15, d + 0.5), vec3(l + 0.3, -0.08, d + 0.9));
    add_still(scene, "steps", steps, looks.stone);

    // A slot along the north wall lets the sun wash the wall's top, out of reach of anything below.
    let slot = -d + SLOT;
    let roof = MeshBuilder::new(0.4).cuboid(vec3(-l - 0.4, h, slot), vec3(l + 0.4, h + 0.3, d + 0.6));
    add_still(scene, "roof", roof, looks.plaster);
    let beams = (0..8).fold(MeshBuilder::new(0.8), |builder, i| {
        let x = -l + 1.125 + 2.25 * i as f32;
        builder
            .cuboid(vec3(x - 0.09, h - 0.24, -d), vec3(x + 0.09, h, -WALL))
            .cuboid(vec3(x - 0.09, h - 0.24, WALL), vec3(x + 0.09, h, d))
    });
    add_still(scene, "beams", beams, looks.oak);
    let north = MeshBuilder::new(0.5).cuboid(vec3(-l, 0.0, -d - 0.2), vec3(l, BRICK_HEIGHT, -d));
    add_still(scene, "north wall", north, looks.bricks);
    let band = MeshBuilder::new(0.5)
        .cuboid(vec3(-l, BRICK_HEIGHT, -d - 0.2), vec3(l, h + 0.3, -d))
        .cuboid(vec3(-l, BRICK_HEIGHT - 0.06, -d), vec3(l, BRICK_HEIGHT, -d + 0.05));
    add_still(scene, "north band", band, looks.plaster);
    let west = MeshBuilder::new(0.5).cuboid(vec3(-l - 0.2, 0.0, -d - 0.2), vec3(-l, h, d));
    add_still(scene, "west wall", west, looks.terracotta);
    let east = MeshBuilder::new(0.5).cuboid(vec3(l, 0.0, -d - 0.2), vec3(l + 0.2, h, d));
    add_still(scene, "east wall", east, looks.teal);

    let (inner, outer) = (DOOR - DOOR_HALF_WIDTH, DOOR + DOOR_HALF_WIDTH);
    let mut wall = MeshBuilder::new(0.5)
        .cuboid(vec3(-inner, 0.0, -WALL), vec3(inner, WALL_HEIGHT, WALL))
        .cuboid(vec3(-l, 0.0, -WALL), vec3(-outer, WALL_HEIGHT, WALL))
        .cuboid(vec3(outer, 0.0, -WALL), vec3(l, WALL_HEIGHT, WALL))
        .cuboid(vec3(-l, h - 0.35, -WALL), vec3(l, h, WALL));
    for side in [-1.0, 1.0] {
        let (a, b) = (side * DOOR - DOOR_HALF_WIDTH, side * DOOR + DOOR_HALF_WIDTH);
        wall = wall.cuboid(vec3(a, 2.6, -WALL), vec3(b, WALL_HEIGHT, WALL));
    }
    add_still(scene, "middle wall", wall, looks.plaster);
    let skirting = [-WALL - 0.015, WALL, -DEPTH].into_iter().fold(MeshBuilder::new(1.0), |builder, z| {
        let strip =
            |builder: MeshBuilder, a: f32, b: f32| builder.cuboid(vec3(a, 0.0, z), vec3(b, 0.12, z + 0.015));
        if z == -DEPTH {
            strip(builder, -l, l)
        } else {
            strip(strip(strip(builder, -inner, inner), -l, -outer), outer, l)
        }
    });
    add_still(scene, "skirting", skirting, looks.oak);
    let posts = (-4..=4).fold(MeshBuilder::new(1.0), |builder, i| {
        let profile = [(0.07, 0.0), (0.07, h - 0.35 - WALL_HEIGHT)];
        builder.lathe(vec3(2.0 * i as f32, WALL_HEIGHT, 0.0), &profile, 16)
    });
    add_still(scene, "posts", posts, looks.stone);
}

fn colonnade(scene: &mut Scene, looks: &Looks) {
    let z = DEPTH - 0.1;
    let column = [
        (0.0, 0.0),
        (0.42, 0.0),
        (0.42, 0.0),
        (0.42, 0.14),
        (0.42, 0.14),
        (0.37, 0.17),
        (0.36, 0.24),
        (0.30, 0.30),
        (0.30, 0.30),
        (0.305, 1.3),
        (0.255, 3.1),
        (0.255, 3.1),
        (0.30, 3.16),
        (0.38, 3.30),
        (0.38, 3.30),
        (0.42, 3.30),
        (0.42, 3.30),
        (0.42, 3.42),
    ];
    let places: Vec<f32> = (0..7).map(|i| -7.8 + 2.6 * i as f32).collect();
    let columns = places.iter().fold(MeshBuilder::new(0.5), |b, &x| b.lathe(vec3(x, 0.0, z), &column, 40));
    add_still(scene, "columns", columns, looks.stone);
    let lintel =
        MeshBuilder::new(0.5).cuboid(vec3(-HALF_LENGTH, 3.42, z - 0.4), vec3(HALF_LENGTH, HEIGHT, z + 0.4));
    add_still(scene, "lintel", lintel, looks.plaster);

    let mut railing = MeshBuilder::new(2.0);
    for pair in places.windows(2) {
        let (a, b) = (pair[0] + 0.31, pair[1] - 0.31);
        railing = railing
            .cuboid(vec3(a, 0.98, z - 0.03), vec3(b, 1.02, z + 0.03))
            .cuboid(vec3(a, 0.10, z - 0.015), vec3(b, 0.13, z + 0.015));
        let bars = ((b - a) / 0.13) as i32;
        for i in 1..bars {
            let x = a + (b - a) * i as f32 / bars as f32;
            railing = railing.lathe(vec3(x, 0.12, z), &[(0.011, 0.0), (0.011, 0.87)], 8);
        }
    }
    add_still(scene, "railing", railing, looks.iron);
}

/// Pictures in frames, hung so that their middle is at eye height.
fn paintings(scene: &mut Scene, looks: &Looks) {
    let size = 1.25;
    let mut frames = MeshBuilder::new(1.0);
    // (x, z of the wall's face, +1 where it faces +z, which picture)
    let places = [
        (-3.4, WALL, 1.0, 1),
        (-1.1, WALL, 1.0, 0),
        (1.3, WALL, 1.0, 2),
        (3.6, WALL, 1.0, 3),
        (-3.0, -WALL, -1.0, 3),
        (3.0, -WALL, -1.0, 1),
        (-5.6, -DEPTH, 1.0, 2),
        (-3.2, -DEPTH, 1.0, 0),
        (3.4, -DEPTH, 1.0, 1),
        (5.8, -DEPTH, 1.0, 3),
    ];
    for (i, &(x, z, side, picture)) in places.iter().enumerate() {
        let right = Vec3::X * side;
        let corner = vec3(x, 1.65 - 0.5 * size, z + side * 0.035) - right * 0.5 * size;
        let canvas = MeshBuilder::default().picture(corner, right * size, Vec3::Y * size);
        add_still(scene, &format!("painting {i}"), canvas, looks.paintings[picture]);
        let (low, high, bar) = (-0.5 * size, 0.5 * size, 0.06);
        let bars = [
            (low - bar, low - bar, high + bar, low),
            (low - bar, high, high + bar, high + bar),
            (low - bar, low, low, high),
            (high, low, high + bar, high),
        ];
        for (x0, y0, x1, y1) in bars {
            let (near, far) = (z.min(z + side * 0.06), z.max(z + side * 0.06));
            frames = frames.cuboid(vec3(x + x0, 1.65 + y0, near), vec3(x + x1, 1.65 + y1, far));
        }
    }
    add_still(scene, "frames", frames, looks.gold);
}

fn pedestal(builder: MeshBuilder, x: f32, z: f32, height: f32) -> MeshBuilder {
    let (r, cap) = (0.24, 0.30);
    builder
        .cuboid(vec3(x - r, 0.0, z - r), vec3(x + r, height - 0.05, z + r))
        .cuboid(vec3(x - cap, height - 0.05, z - cap), vec3(x + cap, height, z + cap))
}

fn exhibits(scene: &mut Scene, looks: &Looks) {
    let spots = [(0.1, 1.0), (4.4, 0.95), (-4.4, 0.95)];
    let bases = spots.iter().fold(MeshBuilder::new(0.8), |b, &(x, height)| pedestal(b, x, 1.15, height));
    let bases = [(-4.4, 0.8), (4.6, 0.8)].iter().fold(bases, |b, &(x, height)| pedestal(b, x, -4.3, height));
    add_still(scene, "pedestals", bases, looks.stone);

    // Turning: two linked rings.
    let upright = Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let ring = MeshBuilder::new(1.0).torus(Vec3::ZERO, 0.30, 0.075, 64).transformed(upright);
    let centre = vec3(0.1, 1.42, 1.15);
    scene.add(ring.build("gold ring", looks.gold), Node::spinning(Trs::at(centre), Vec3::Y, 6.0));
    let tilt = Trs { rotation: Quat::from_rotation_z(0.35), ..Trs::at(centre) };
    let inner = MeshBuilder::new(1.0).torus(Vec3::ZERO, 0.19, 0.045, 48);
    scene.add(inner.build("steel ring", looks.steel), Node::spinning(tilt, Vec3::Y, -4.0));

    let ball = |radius: f32, rings| MeshBuilder::new(1.0).sphere(Vec3::ZERO, radius, rings);
    let still = |p| Node::still(Trs::at(p));
    scene.add(ball(0.30, 32).build("copper ball", looks.copper), still(vec3(4.4, 1.25, 1.15)));
    scene.add(ball(0.28, 32).build("chrome ball", looks.chrome), still(vec3(4.6, 1.08, -4.3)));
    let vase = [
        (0.0, 0.0),
        (0.14, 0.0),
        (0.15, 0.03),
        (0.21, 0.16),
        (0.235, 0.28),
        (0.20, 0.42),
        (0.11, 0.54),
        (0.085, 0.60),
        (0.10, 0.66),
        (0.14, 0.70),
        (0.125, 0.70),
        (0.08, 0.64),
    ];
    let vases = MeshBuilder::new(1.0).lathe(Vec3::ZERO, &vase, 48).build("vase", looks.red);
    scene.add(vases.clone(), still(vec3(-4.4, 0.95, 1.15)));
    scene.add(vases, still(vec3(-4.4, 0.80, -4.3)));

    // Moving: a ball that rolls to and fro along the brick wall.
    const KEYS: usize = 48;
    const PERIOD: f32 = 8.0;
    let (reach, radius) = (2.6, 0.26);
    let place = |i: usize| reach * (i as f32 / KEYS as f32 * std::f32::consts::TAU).sin();
    let keys = |i: usize| (i as f32 / KEYS as f32 * PERIOD, place(i));
    let translation = (0..=KEYS).map(|i| (keys(i).0, vec3(place(i), radius + 0.08, -4.55))).collect();
    let rotation = (0..=KEYS).map(|i| (keys(i).0, Quat::from_rotation_z(-place(i) / radius))).collect();
    let track = |keys| Track { keys, interpolation: Interpolation::Linear, period: PERIOD };
    let turn = Track { keys: rotation, interpolation: Interpolation::Linear, period: PERIOD };
    let animation =
        NodeAnimation { translation: Some(track(translation)), rotation: Some(turn), scale: None };
    let mesh = ball(radius, 32).build("rolling ball", looks.paintings[3]);
    scene.add(mesh, Node { animation: Some(animation), ..Node::still(Trs::IDENTITY) });
    let rails = [-4.65, -4.45].iter().fold(MeshBuilder::new(1.0), |builder, z| {
        builder.cuboid(vec3(-3.2, 0.0, z - 0.02), vec3(3.2, 0.1, z + 0.02))
    });
    add_still(scene, "rails", rails, looks.steel);

    let bench = |builder: MeshBuilder, x: f32, z: f32| {
        let legs = [-0.75_f32, 0.69].iter().fold(builder, |b, dx| {
            b.cuboid(vec3(x + dx, 0.0, z - 0.18), vec3(x + dx + 0.06, 0.42, z + 0.18))
        });
        legs.cuboid(vec3(x - 0.85, 0.42, z - 0.22), vec3(x + 0.85, 0.48, z + 0.22))
    };
    let benches = bench(bench(MeshBuilder::new(0.7), 2.2, -0.75), -2.2, 4.5);
    add_still(scene, "benches", benches, looks.oak);
}

/// Hangs in the middle of the hall; on for the larger part of its period, then off.
fn lamp(scene: &mut Scene, looks: &Looks) {
    const PERIOD: f32 = 6.0;
    const ON: f32 = 3.5;
    let glow = scene.add_material(Material {
        name: "lamp".into(),
        base_color: [0.85, 0.85, 0.85, 1.0],
        emissive: [42.0, 29.0, 16.5],
        emission_scale: Some(Track {
            keys: vec![(0.0, 1.0), (ON, 0.0)],
            interpolation: Interpolation::Step,
            period: PERIOD,
        }),
        ..Default::default()
    });
    let globe = MeshBuilder::new(1.0).sphere(vec3(0.0, 2.75, -2.9), 0.24, 12);
    add_still(scene, "lamp", globe, glow);
    let cord = [(0.012, 0.0), (0.012, 1.25)];
    let cap = [(0.13, 0.0), (0.11, 0.05), (0.02, 0.09)];
    let fitting =
        MeshBuilder::new(1.0).lathe(vec3(0.0, 2.98, -2.9), &cord, 8).lathe(vec3(0.0, 2.95, -2.9), &cap, 24);
    add_still(scene, "lamp fitting", fitting, looks.iron);
}

/// A lattice of slats across half of the hall's east end.
fn screen(scene: &mut Scene, looks: &Looks) {
    let (x, low, high) = (-7.6, -4.6, -2.9);
    let slats = (0..=17).fold(MeshBuilder::new(1.0), |builder, i| {
        let z = low + (high - low) * i as f32 / 17.0;
        builder.cuboid(vec3(x - 0.02, 0.0, z - 0.014), vec3(x + 0.02, 2.4, z + 0.014))
    });
    let frame = [0.02, 1.2, 2.36].iter().fold(slats, |builder, &y| {
        builder.cuboid(vec3(x - 0.03, y, low - 0.03), vec3(x + 0.03, y + 0.05, high + 0.03))
    });
    add_still(scene, "screen", frame, looks.oak);
}

/// What is seen between the columns.
fn garden(scene: &mut Scene, looks: &Looks) {
    let cypress = [
        (0.0, 0.0),
        (0.10, 0.0),
        (0.10, 0.5),
        (0.55, 0.8),
        (0.70, 1.6),
        (0.55, 3.2),
        (0.25, 4.6),
        (0.0, 5.4),
    ];
    let hedge = MeshBuilder::new(1.0)
        .cuboid(vec3(-30.0, -0.15, 17.0), vec3(-1.5, 1.1, 18.0))
        .cuboid(vec3(1.5, -0.15, 17.0), vec3(30.0, 1.1, 18.0));
    let garden = (-5..=5).fold(hedge, |builder, i| {
        let size = 1.0 + 0.12 * ((i * i * 7) % 5) as f32;
        let profile = cypress.map(|(r, y)| (r * size, y * size));
        builder.lathe(vec3(4.6 * i as f32 + 2.3, -0.15, 20.5), &profile, 20)
    });
    add_still(scene, "garden", garden, looks.leaves);
    let path = MeshBuilder::new(1.0).cuboid(vec3(-1.3, -0.16, DEPTH + 0.9), vec3(1.3, -0.13, 60.0));
    add_still(scene, "path", path, looks.stone);
}

/// Along the colonnade, through the east door, back through the hall, out of the west door.
fn walk() -> CameraPath {
    let eye = |x: f32, z: f32| vec3(x, 1.68, z);
    let at = |x: f32, y: f32, z: f32| vec3(x, y, z);
    let points = vec![
        (eye(-6.2, 3.3), at(0.0, 1.45, 2.5)),
        (eye(-3.6, 3.5), at(2.0, 1.35, 2.0)),
        (eye(-0.8, 3.4), at(4.0, 1.35, 1.6)),
        (eye(2.2, 3.2), at(6.2, 1.4, 0.6)),
        (eye(4.8, 2.6), at(6.5, 1.5, -2.0)),
        (eye(6.0, 0.9), at(5.6, 1.5, -4.0)),
        (eye(5.9, -1.1), at(2.5, 1.4, -3.9)),
        (eye(4.4, -2.2), at(-1.0, 1.4, -3.7)),
        (eye(1.6, -2.2), at(-4.0, 1.4, -3.4)),
        (eye(-1.4, -2.1), at(-6.5, 1.4, -2.6)),
        (eye(-4.2, -2.0), at(-7.0, 1.45, 0.2)),
        (eye(-5.9, -0.9), at(-5.4, 1.5, 3.0)),
        (eye(-6.3, 1.2), at(-2.2, 1.5, 4.4)),
    ];
    CameraPath::Spline { points, vertical_fov: 1.05, duration: WALK_S, closed: true }
}
