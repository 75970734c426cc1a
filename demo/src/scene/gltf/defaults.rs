//! What a file leaves open: light and a camera path.

use super::Placed;
use crate::scene::{CameraPath, CameraPose, PunctualKind, Scene, Sky, Sun};
use glam::Vec3;

/// Half the angle at which the sun is seen from the earth.
const SUN_ANGULAR_RADIUS: f32 = 0.004_65;

pub(super) fn complete(scene: &mut Scene, placed: &Placed<'_>) {
    promote_directional(scene);
    let has_emitter = scene.instances.iter().any(|i| {
        let material = scene.meshes[i.mesh].material;
        scene.materials[material].is_emissive()
    });
    let (low, high) = scene.bounds();
    let is_lit = has_emitter || scene.sun.is_some() || !scene.punctual_lights.is_empty();
    if !is_lit {
        let along = if high.x - low.x >= high.z - low.z { Vec3::X } else { Vec3::Z };
        let across = Vec3::Y.cross(along);
        // High enough to reach the floor between walls, slanted enough to leave them light.
        scene.sun = Some(Sun {
            direction: (Vec3::Y + 0.40 * along + 0.12 * across).normalize(),
            irradiance: Vec3::new(32.0, 28.5, 23.5),
            angular_radius: SUN_ANGULAR_RADIUS,
        });
        scene.sky = Sky {
            zenith: Vec3::new(3.2, 5.2, 9.0),
            horizon: Vec3::new(6.4, 7.2, 8.2),
            ground: Vec3::new(1.6, 1.5, 1.4),
        };
    }
    scene.camera_path = camera(scene, placed, low, high);
}

/// The brightest directional light becomes a sun, with a disc and soft shadows; others stay without extent.
fn promote_directional(scene: &mut Scene) {
    let is_directional = |&i: &usize| matches!(scene.punctual_lights[i].kind, PunctualKind::Directional);
    let brightness = |i: usize| scene.punctual_lights[i].intensity.element_sum();
    let brightest = (0..scene.punctual_lights.len())
        .filter(is_directional)
        .max_by(|&a, &b| brightness(a).total_cmp(&brightness(b)));
    let Some(light) = brightest.map(|i| scene.punctual_lights[i]) else {
        return;
    };
    let axis = scene.pose(0.0).world_from_node[light.node].transform_vector3(Vec3::Z);
    scene.sun = Some(Sun {
        direction: axis.normalize_or(Vec3::Y),
        irradiance: light.intensity,
        angular_radius: SUN_ANGULAR_RADIUS,
    });
    scene.punctual_lights.retain(|l| *l != light);
}

fn camera(scene: &Scene, placed: &Placed<'_>, low: Vec3, high: Vec3) -> CameraPath {
    let (centre, size) = (0.5 * (low + high), high - low);
    let is_walkable = size.x.max(size.z) > 1.5 * size.y && size.x.min(size.z) > 0.3 * size.y;
    let animated = scene.animated_nodes();
    let mut still = None;
    for (document_node, &node) in placed.iter() {
        let Some(camera) = document_node.camera() else {
            continue;
        };
        let gltf::camera::Projection::Perspective(lens) = camera.projection() else {
            continue;
        };
        let (vertical_fov, distance) = (lens.yfov().clamp(0.05, 2.5), 0.5 * size.length());
        let path = CameraPath::Node { node, vertical_fov, distance };
        if animated[node] {
            return path;
        }
        still = still.or(Some(path));
    }
    if is_walkable && is_roomy(scene, centre, size) {
        return walk(floor_height(scene, centre, size), size, centre);
    }
    if let Some(path) = still {
        let pose = path.at(scene, 0.0);
        return CameraPath::Sway { pose, amplitude: 0.02 * size.length(), period: 12.0 };
    }
    // A small thing or a box: from the front, a little above.
    let vertical_fov = 0.7_f32;
    let distance = 0.5 * size.y.max(size.x * 9.0 / 16.0) / (0.5 * vertical_fov).tan() + 0.5 * size.z;
    let open_front = open_side(scene, centre, size);
    let eye = centre + open_front * distance * 1.03;
    let pose = CameraPose { eye, target: centre, up: Vec3::Y, vertical_fov };
    CameraPath::Sway { pose, amplitude: 0.06 * size.length(), period: 12.0 }
}

/// There and back along the longest horizontal axis at eye height, looking ahead and slightly about.
fn walk(floor: f32, size: Vec3, centre: Vec3) -> CameraPath {
    const EYE_HEIGHT: f32 = 1.7;
    const STOPS: usize = 5;
    // The middle part of the axis: its ends are the outer walls.
    const REACH: f32 = 0.42;
    let (along, across) = if size.x >= size.z { (Vec3::X, Vec3::Z) } else { (Vec3::Z, Vec3::X) };
    let (length, width) = (size.dot(along), size.dot(across));
    let floor = Vec3::new(centre.x, floor, centre.z);
    let point = |i: usize| {
        let t = i as f32 / (STOPS - 1) as f32;
        let side = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let eye =
            floor + along * length * REACH * (0.5 - t) + across * width * 0.02 * side + Vec3::Y * EYE_HEIGHT;
        let target = eye - along * 0.25 * length + across * width * 0.06 * side + Vec3::Y * 0.02 * length;
        (eye, target)
    };
    // A stroll at about one metre a second.
    let duration = (length * REACH).clamp(10.0, 60.0);
    CameraPath::Spline { points: (0..STOPS).map(point).collect(), vertical_fov: 1.0, duration, closed: false }
}

/// Height of what is under the middle of a building, from half its height down.
fn floor_height(scene: &Scene, centre: Vec3, size: Vec3) -> f32 {
    let pose = scene.pose(0.0);
    let mut floor = centre.y - 0.5 * size.y;
    for instance in &scene.instances {
        let world = pose.world_from_node[instance.node];
        let mesh = &scene.meshes[instance.mesh];
        for triangle in &mesh.triangles {
            let corners =
                triangle.map(|i| world.transform_point3(mesh.vertices[i as usize].position) - centre);
            if let Some(y) = height_at_origin(corners).filter(|y| *y < 0.0) {
                floor = floor.max(centre.y + y);
            }
        }
    }
    floor
}

/// Where a vertical line through the origin meets a triangle.
fn height_at_origin(corners: [Vec3; 3]) -> Option<f32> {
    let [a, b, c] = corners.map(|p| glam::Vec2::new(p.x, p.z));
    let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let is_inside = weights.iter().all(|w| *w >= 0.0) || weights.iter().all(|w| *w <= 0.0);
    let area: f32 = weights.iter().sum();
    let height: f32 = weights.iter().zip(corners).map(|(w, p)| w * p.y).sum();
    (is_inside && area != 0.0).then(|| height / area)
}

/// Whether it is a building to be inside of, rather than a thing to look at.
fn is_roomy(scene: &Scene, centre: Vec3, size: Vec3) -> bool {
    let across = if size.x >= size.z { Vec3::Z } else { Vec3::X };
    let has_walls = [across, -across].iter().all(|&side| coverage(scene, centre, size, side) > 0.3);
    size.y > 2.5 && size.max_element() > 8.0 && has_walls
}

/// The horizontal direction in which the least stands in the way.
fn open_side(scene: &Scene, centre: Vec3, size: Vec3) -> Vec3 {
    let mut best = (f32::INFINITY, Vec3::Z);
    for side in [Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::NEG_X] {
        let covered = coverage(scene, centre, size, side);
        if covered < best.0 - 0.05 {
            best = (covered, side);
        }
    }
    best.1
}

/// Area of what lies near a side of the bounds and faces it, over the side's area.
fn coverage(scene: &Scene, centre: Vec3, size: Vec3, side: Vec3) -> f32 {
    const NEAR: f32 = 0.6;
    let pose = scene.pose(0.0);
    let half = 0.5 * size.dot(side.abs());
    let mut area = 0.0;
    for instance in &scene.instances {
        let world = pose.world_from_node[instance.node];
        let mesh = &scene.meshes[instance.mesh];
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| world.transform_point3(mesh.vertices[i as usize].position));
            if ((a + b + c) / 3.0 - centre).dot(side) > NEAR * half {
                area += 0.5 * (b - a).cross(c - a).dot(side).abs();
            }
        }
    }
    let side_area = size.x * size.y * size.z / (2.0 * half).max(1e-12);
    area / side_area.max(1e-12)
}
