//! Radiance split by the lobe through which it left the first hit.

use crate::scenes::{lit_box, look_at};
use crate::{GPU, half, mean_and_error, read, still};
use glam::{Vec3, vec3};
use quell_demo::gbuffer::{GBuffer, Split};
use quell_demo::scene::{CameraPose, Material, MeshBuilder, Node, Scene, Sky, Trs};
use quell_demo::tracer::{Sampling, TraceSettings, Tracer};

const SIZE: u32 = 24;

/// The images of one frame, per pixel.
struct Images {
    radiance: Vec<Vec3>,
    rest: Vec<Vec3>,
    specular: Vec<Vec3>,
    specular_albedo: Vec<Vec3>,
    hit_distance: Vec<f32>,
    depth: Vec<f32>,
    samples: Vec<u32>,
}

fn rgb(view: &wgpu::TextureView) -> Vec<Vec3> {
    read::<[f32; 4]>(view).iter().map(|texel| Vec3::from_slice(texel)).collect()
}

fn encode(tracer: &Tracer, pose: &CameraPose, settings: &TraceSettings, out: &GBuffer) {
    let mut encoder = GPU.device.create_command_encoder(&Default::default());
    tracer.encode(&GPU, &mut encoder, &still(pose, SIZE, 0.0), settings, out);
    GPU.queue.submit([encoder.finish()]);
}

fn trace(scene: &Scene, pose: &CameraPose, settings: &TraceSettings) -> Images {
    let tracer = Tracer::new(&GPU, scene).expect("the scene fits");
    let out = GBuffer::with_split(&GPU.device, SIZE, SIZE, Split::Full);
    // What a frame leaves is not what the next one finds.
    for frame in [settings.frame + 1, settings.frame] {
        encode(&tracer, pose, &TraceSettings { frame, ..*settings }, &out);
    }
    let lobes = out.lobes.as_ref().expect("full");
    let albedo = read::<[u16; 4]>(out.specular_albedo.as_ref().expect("full"));
    Images {
        radiance: rgb(&out.radiance),
        rest: rgb(&lobes.rest),
        specular: rgb(&lobes.specular),
        specular_albedo: albedo.iter().map(|a| Vec3::from([0, 1, 2].map(|c| half(a[c])))).collect(),
        hit_distance: read(out.hit_distance.as_ref().expect("full")),
        depth: read(&out.depth),
        samples: read(&out.sample_count),
    }
}

/// A box in front of the sky.
fn box_in_the_open() -> (Scene, CameraPose) {
    let (mut scene, _) = lit_box();
    scene.sky = Sky::constant(vec3(0.25, 0.5, 0.75));
    (scene, look_at(vec3(0.5, 0.7, 4.0), Vec3::ZERO, 0.9))
}

/// A sphere of `material` that fills the view, in a sky of radiance 1. A small angle sees it at normal incidence.
fn furnace(material: Material, vertical_fov: f32) -> (Scene, CameraPose) {
    let mut scene = Scene::empty("furnace");
    scene.sky = Sky::constant(Vec3::ONE);
    let material = scene.add_material(material);
    let ball = MeshBuilder::new(1.0).sphere(Vec3::ZERO, 1.0, 48).build("ball", material);
    scene.add(ball, Node::still(Trs::IDENTITY));
    (scene, look_at(vec3(0.0, 0.3, 3.0), Vec3::ZERO, vertical_fov))
}

/// Largest part of a sum by which it may miss what it is the sum of: tens of roundings.
const ROUNDING: f32 = 1e-5;

/// Whether radiance is the sum of the two at every pixel.
fn sums_up(images: &Images, rest: &[Vec3], specular: &[Vec3]) -> bool {
    let close = |(whole, sum): (&Vec3, Vec3)| {
        (*whole - sum).abs().max_element() <= ROUNDING * (1.0 + whole.max_element())
    };
    images.radiance.iter().zip(rest.iter().zip(specular).map(|(r, s)| r + s)).all(close)
}

#[test]
fn the_two_sum_to_the_radiance_of_the_same_paths() {
    let (scene, pose) = lit_box();
    let settings = TraceSettings { spp: 3.0, frame: 4, seed: 7, ..Default::default() };
    let images = trace(&scene, &pose, &settings);
    assert!(sums_up(&images, &images.rest, &images.specular));
    let share = images.specular.iter().sum::<Vec3>() / images.radiance.iter().sum::<Vec3>();
    assert!((0.01..0.99).contains(&share.y), "too little of one to tell: {share}");
    // The comparison sees what it is to see: a hundredth too much of one, and the one in the place of the other.
    let brighter: Vec<Vec3> = images.specular.iter().map(|s| 1.01 * s).collect();
    assert!(
        !sums_up(&images, &images.rest, &brighter) && !sums_up(&images, &images.specular, &images.specular)
    );
}

#[test]
fn combined_radiance_is_the_same_to_the_bit_with_and_without_the_split() {
    let (scene, pose) = lit_box();
    let settings = TraceSettings { spp: 2.0, frame: 3, ..Default::default() };
    let whole = GBuffer::new(&GPU.device, SIZE, SIZE);
    encode(&Tracer::new(&GPU, &scene).expect("the scene fits"), &pose, &settings, &whole);
    assert_eq!(trace(&scene, &pose, &settings).radiance, rgb(&whole.radiance));
}

#[test]
fn a_surface_without_a_lobe_has_nothing_in_it() {
    let bright = Material { base_color: [0.7, 0.5, 0.3, 1.0], roughness: 0.3, ..Default::default() };
    let diffuse = Material { specular: 0.0, ..bright.clone() };
    let metal = Material { metallic: 1.0, ..bright };
    let settings = TraceSettings { spp: 8.0, ..Default::default() };
    let (scene, pose) = furnace(diffuse, 0.35);
    let images = trace(&scene, &pose, &settings);
    assert!(images.specular.iter().chain(&images.specular_albedo).all(|&s| s == Vec3::ZERO));
    assert!(images.hit_distance.iter().all(|&distance| distance == 0.0));
    assert_eq!(images.rest, images.radiance);
    let (scene, pose) = furnace(metal, 0.35);
    let images = trace(&scene, &pose, &settings);
    assert!(images.rest.iter().all(|&rest| rest == Vec3::ZERO));
    assert!(sums_up(&images, &images.rest, &images.specular));
}

fn green(pixels: &[Vec3]) -> Vec<f32> {
    pixels.iter().map(|pixel| pixel.y).collect()
}

/// In even light, integrated with other directions than those of paths.
#[test]
fn the_specular_part_converges_to_its_albedo_in_a_furnace() {
    for (roughness, metallic) in [(0.1, 0.0), (0.5, 0.0), (1.0, 0.0), (0.3, 0.5), (0.2, 1.0), (0.8, 1.0)] {
        let material =
            Material { base_color: [0.9, 0.6, 0.3, 1.0], roughness, metallic, ..Default::default() };
        let (scene, pose) = furnace(material, 0.35);
        let images = trace(&scene, &pose, &TraceSettings { spp: 256.0, ..Default::default() });
        let albedo = green(&images.specular_albedo);
        let is_albedo = |factor: f32| {
            let off =
                green(&images.specular).iter().zip(&albedo).map(|(s, a)| s - factor * a).collect::<Vec<_>>();
            let (mean, error) = mean_and_error(&off);
            // A hundredth for half precision and for what 32 directions miss.
            mean.abs() < 4.0 * error + 0.01 * mean_and_error(&albedo).0
        };
        assert!(is_albedo(1.0), "roughness {roughness}, metallic {metallic}");
        assert!(!is_albedo(1.1), "a tenth too much must show");
    }
}

#[test]
fn each_part_keeps_what_the_integral_says_at_normal_incidence() {
    let half_metal = Material { base_color: [0.8; 4], roughness: 1.0, metallic: 0.5, ..Default::default() };
    let (scene, pose) = furnace(half_metal, 0.02);
    let images = trace(&scene, &pose, &TraceSettings { spp: 256.0, ..Default::default() });
    // A coat of 0.04 over half of the base colour.
    let rest = 0.4 * (1.0 - 0.04);
    // As of the roughest metal, here of reflectance 0.42; what grazing directions add is 0.0001 at most.
    let specular = (0.5 * 0.04 + 0.5 * 0.8) * (1.0 - 2.0_f32.ln());
    for (name, found, expected) in [("rest", &images.rest, rest), ("specular", &images.specular, specular)] {
        let (mean, error) = mean_and_error(&green(found));
        assert!((mean - expected).abs() < 0.002 + 4.0 * error, "{name}: {mean} +- {error} for {expected}");
        assert!(error < 0.002, "{name}: too noisy to tell");
    }
}

#[test]
fn hit_distances_are_those_of_mirrored_things() {
    let (scene, pose) = mirror_room();
    let images = trace(&scene, &pose, &TraceSettings { spp: 4.0, ..Default::default() });
    let mut seen = [0; 2];
    for (i, &distance) in images.hit_distance.iter().enumerate() {
        let (x, y) = (i as u32 % SIZE, i as u32 / SIZE);
        let view = still(&pose, SIZE, 0.0).camera;
        let at = crate::unproject(&view, glam::vec2(x as f32, y as f32) + 0.5, images.depth[i], SIZE);
        let direction = (at - pose.eye).normalize() * vec3(1.0, -1.0, 1.0);
        // A wall at z = -2, up to a height of 3.
        let to_wall = (-2.0 - at.z) / direction.z;
        let expected = if at.y + to_wall * direction.y < 3.0 { to_wall } else { 1e30 };
        seen[usize::from(expected == 1e30)] += 1;
        assert!((distance / expected - 1.0).abs() < 0.02, "{distance} instead of {expected} at {x} {y}");
    }
    assert!(seen.iter().all(|&count| count > 20), "{seen:?}");
}

/// A mirror on the floor that fills the view, and a wall behind it.
fn mirror_room() -> (Scene, CameraPose) {
    let mut scene = Scene::empty("mirror");
    scene.sky = Sky::constant(Vec3::ONE);
    let mirror = scene.add_material(Material {
        base_color: [1.0; 4],
        metallic: 1.0,
        roughness: 0.0,
        ..Default::default()
    });
    let wall = scene.add_material(Material::default());
    let floor = MeshBuilder::new(1.0).quad(vec3(-20.0, 0.0, 20.0), Vec3::X * 40.0, Vec3::NEG_Z * 21.5);
    scene.add(floor.build("floor", mirror), Node::still(Trs::IDENTITY));
    let quad = MeshBuilder::new(1.0).quad(vec3(-20.0, 0.0, -2.0), Vec3::X * 40.0, Vec3::Y * 3.0);
    scene.add(quad.build("wall", wall), Node::still(Trs::IDENTITY));
    (scene, look_at(vec3(0.0, 3.0, 3.0), vec3(0.0, 0.0, 1.0), 0.5))
}

#[test]
fn nothing_is_left_of_an_earlier_frame_where_nothing_is_traced() {
    let (scene, pose) = box_in_the_open();
    let settings = TraceSettings { spp: 0.5, sampling: Sampling::Checkerboard, ..Default::default() };
    let images = trace(&scene, &pose, &settings);
    let untraced = (0..images.samples.len()).filter(|&i| images.samples[i] == 0);
    let black = untraced.filter(|&i| {
        let [rest, specular] = [images.rest[i], images.specular[i]];
        assert_eq!((rest, specular, images.hit_distance[i]), (Vec3::ZERO, Vec3::ZERO, 0.0), "pixel {i}");
        true
    });
    assert!(black.count() > 50);
}

#[test]
fn a_miss_has_no_lobes() {
    let (scene, pose) = box_in_the_open();
    let images = trace(&scene, &pose, &TraceSettings::default());
    let sky: Vec<usize> = (0..images.depth.len()).filter(|&i| !images.depth[i].is_finite()).collect();
    assert!(sky.len() > 20);
    for i in sky {
        assert_eq!(images.rest[i], images.radiance[i]);
        assert_eq!((images.specular[i], images.specular_albedo[i]), (Vec3::ZERO, Vec3::ONE));
        assert_eq!(images.hit_distance[i], 0.0);
    }
}
