//! The path tracer against what is known without it.

mod gltf_files;
mod sampling;
mod scenes;
mod shaders;
mod split;
#[path = "../../../tests/portability/tint.rs"]
mod tint;

use glam::{Affine3A, Vec2, Vec3, Vec4, vec2, vec3};
use quell_demo::gbuffer::GBuffer;
use quell_demo::gpu::Gpu;
use quell_demo::scene::{CameraPose, Material, MeshBuilder, Node, Scene, Sky, Sun, Trs};
use quell_demo::tracer::{FrameView, ReferenceImage, Strategy, TraceSettings, Tracer, camera_of};
use scenes::{lit_box, look_at};
use std::sync::LazyLock;

static GPU: LazyLock<Gpu> = LazyLock::new(|| Gpu::new().expect("tests need a GPU or a CPU driver of one"));

fn still(pose: &CameraPose, size: u32, time_s: f32) -> FrameView {
    FrameView { camera: camera_of(pose, size, size), time_s, previous: None }
}

/// Mean radiance per pixel of `frames` frames of `settings.spp` samples.
fn converge(
    scene: &Scene,
    pose: &CameraPose,
    size: u32,
    settings: &TraceSettings,
    frames: u32,
) -> Vec<[f32; 3]> {
    let tracer = Tracer::new(&GPU, scene).expect("the scene fits");
    let reference = ReferenceImage::new(&GPU.device, size, size);
    for frame in 0..frames {
        let mut encoder = GPU.device.create_command_encoder(&Default::default());
        let settings = TraceSettings { frame, ..*settings };
        tracer.accumulate_reference(&GPU, &mut encoder, &still(pose, size, 0.0), &settings, &reference);
        GPU.queue.submit([encoder.finish()]);
    }
    assert_eq!(reference.samples(), frames * settings.spp as u32);
    reference.resolve(&GPU).expect("the reference reads back")
}

/// Traces one frame and returns its images.
fn trace(scene: &Scene, view: &FrameView, settings: &TraceSettings, size: u32) -> GBuffer {
    let tracer = Tracer::new(&GPU, scene).expect("the scene fits");
    let out = GBuffer::new(&GPU.device, size, size);
    let mut encoder = GPU.device.create_command_encoder(&Default::default());
    tracer.encode(&GPU, &mut encoder, view, settings, &out);
    GPU.queue.submit([encoder.finish()]);
    out
}

fn read<T: bytemuck::AnyBitPattern>(view: &wgpu::TextureView) -> Vec<T> {
    let bytes = GPU.read_texture(view.texture()).expect("reads back");
    bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()
}

fn half(bits: u16) -> f32 {
    let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    match exponent {
        0 => sign * mantissa * 2.0_f32.powi(-24),
        31 => sign * f32::INFINITY,
        _ => sign * (1.0 + mantissa / 1024.0) * 2.0_f32.powi(exponent - 15),
    }
}

fn mean_and_error(values: &[f32]) -> (f32, f32) {
    let n = values.len() as f32;
    let mean = values.iter().sum::<f32>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// A sphere that fills the view, in a sky of radiance 1.
fn furnace(material: Material, vertical_fov: f32) -> Vec<f32> {
    let mut scene = Scene::empty("furnace");
    scene.sky = Sky::constant(Vec3::ONE);
    let material = scene.add_material(material);
    let ball = MeshBuilder::new(1.0).sphere(Vec3::ZERO, 1.0, 48).build("ball", material);
    scene.add(ball, Node::still(Trs::IDENTITY));
    let pose = look_at(vec3(0.0, 0.3, 3.0), Vec3::ZERO, vertical_fov);
    let image = converge(&scene, &pose, 32, &TraceSettings { spp: 32.0, ..Default::default() }, 2);
    image.into_iter().map(|p| p[1]).collect()
}

#[test]
fn white_diffuse_surface_vanishes_in_a_furnace() {
    let white = Material { base_color: [1.0; 4], specular: 0.0, ..Default::default() };
    let (mean, _) = mean_and_error(&furnace(white, 0.35));
    assert!((mean - 1.0).abs() < 0.01, "mean {mean}");
}

#[test]
fn reflection_never_adds_energy() {
    // (roughness, metallic, least that single scattering may keep)
    for (roughness, metallic, least) in [
        (0.1, 1.0, 0.97),
        (0.4, 1.0, 0.93),
        (1.0, 1.0, 0.3),
        (0.1, 0.0, 0.95),
        (0.6, 0.0, 0.94),
        (1.0, 0.0, 0.9),
    ] {
        let material = Material { base_color: [1.0; 4], roughness, metallic, ..Default::default() };
        let (mean, error) = mean_and_error(&furnace(material, 0.35));
        assert!(mean < 1.0 + 0.005 + 3.0 * error, "roughness {roughness}, metallic {metallic}: {mean}");
        assert!(mean > least, "roughness {roughness}, metallic {metallic}: {mean} is too dark");
    }
}

#[test]
fn roughest_metal_keeps_what_the_integral_says() {
    // At normal incidence and alpha 1, D = 1 / pi and G2 = 2 c / (1 + c), so the directional albedo is
    // the integral of c / (1 + c) over c from 0 to 1.
    let expected = 1.0 - 2.0_f32.ln();
    let metal = Material { base_color: [1.0; 4], roughness: 1.0, metallic: 1.0, ..Default::default() };
    let (mean, error) = mean_and_error(&furnace(metal, 0.02));
    assert!((mean - expected).abs() < 0.002 + 4.0 * error, "{mean} +- {error} instead of {expected}");
}

#[test]
fn strategies_agree() {
    let (scene, pose) = lit_box();
    let settings =
        |strategy, seed| TraceSettings { spp: 16.0, seed, strategy, max_bounces: 3, ..Default::default() };
    let [mis, lights, bsdf] =
        [(Strategy::Mis, 1), (Strategy::LightsOnly, 2), (Strategy::BsdfOnly, 3)].map(|(s, seed)| {
            let image = converge(&scene, &pose, 32, &settings(s, seed), 8);
            image.into_iter().map(|p| p[1]).collect::<Vec<f32>>()
        });
    for (name, other) in [("lights only", &lights), ("BSDF only", &bsdf)] {
        // Per pixel the images have the same expectation, so their difference has mean 0.
        let difference: Vec<f32> = mis.iter().zip(other).map(|(a, b)| a - b).collect();
        let (mean, error) = mean_and_error(&difference);
        let (level, _) = mean_and_error(&mis);
        assert!(mean.abs() < 4.0 * error + 0.002 * level, "{name}: differs by {mean} +- {error} of {level}");
        assert!(error < 0.03 * level, "{name}: too noisy to tell ({error} of {level})");
    }
}

#[test]
fn sun_lights_a_floor_by_its_irradiance() {
    let mut scene = Scene::empty("floor");
    let floor = scene.add_material(Material {
        base_color: [0.5, 0.5, 0.5, 1.0],
        specular: 0.0,
        ..Default::default()
    });
    let quad = MeshBuilder::new(1.0).quad(vec3(-5.0, 0.0, 5.0), Vec3::X * 10.0, Vec3::NEG_Z * 10.0);
    scene.add(quad.build("floor", floor), Node::still(Trs::IDENTITY));
    let direction = vec3(0.0, 0.8, 0.6);
    scene.sun = Some(Sun { direction, irradiance: Vec3::splat(4.0), angular_radius: 0.01 });
    let pose = look_at(vec3(0.0, 3.0, 0.5), Vec3::ZERO, 0.5);
    let image = converge(&scene, &pose, 16, &TraceSettings { spp: 8.0, ..Default::default() }, 1);
    let (mean, _) = mean_and_error(&image.iter().map(|p| p[0]).collect::<Vec<_>>());
    let expected = 4.0 * 0.8 * 0.5 / std::f32::consts::PI;
    assert!((mean - expected).abs() < 0.005 * expected, "{mean} instead of {expected}");
}

/// A turning and a moving quad over a floor, in front of a camera that moves too.
fn moving_scene() -> Scene {
    let mut scene = scenes::floor();
    let material = scene.add_material(Material::default());
    let quad = || MeshBuilder::new(1.0).quad(vec3(-0.4, -0.4, 0.0), Vec3::X * 0.8, Vec3::Y * 0.8);
    let spin = Node::spinning(Trs::at(vec3(-0.6, 0.8, 0.0)), Vec3::Z, 2.0);
    scene.add(quad().build("turning", material), spin);
    scene.add(
        quad().build("moving", material),
        scenes::sliding(vec3(0.5, 0.8, 0.2), vec3(0.9, 1.0, 0.5), 1.0),
    );
    scene
}

#[test]
fn motion_vectors_are_exact() {
    check_motion(Vec2::ZERO, Vec2::ZERO);
}

/// They lead from where a sample lies to where its surface was, whatever the jitter of the frame before.
#[test]
fn motion_vectors_are_without_jitter() {
    check_motion(vec2(0.4, -0.3), vec2(-0.45, 0.2));
}

fn check_motion(jitter: Vec2, prev_jitter: Vec2) {
    const SIZE: u32 = 64;
    let scene = moving_scene();
    let (time, prev_time) = (0.30, 0.25);
    let pose = look_at(vec3(0.0, 1.0, 3.0), vec3(0.0, 0.6, 0.0), 0.9);
    let prev_pose = look_at(vec3(0.1, 1.05, 3.05), vec3(0.05, 0.6, 0.0), 0.9);
    let camera = quell::Camera { jitter_px: jitter, ..camera_of(&pose, SIZE, SIZE) };
    let prev_camera = quell::Camera { jitter_px: prev_jitter, ..camera_of(&prev_pose, SIZE, SIZE) };
    let view = FrameView { camera, time_s: time, previous: Some((prev_camera, prev_time)) };
    let out = trace(&scene, &view, &TraceSettings::default(), SIZE);
    let depth = read::<f32>(&out.depth);
    let motion = read::<[u16; 4]>(&out.motion);
    let ids = read::<u32>(&out.surface_id);

    let (now, before) = (scene.pose(time), scene.pose(prev_time));
    let mut seen = [0; 4];
    for y in 0..SIZE {
        for x in 0..SIZE {
            let i = (y * SIZE + x) as usize;
            let centre = Vec2::new(x as f32, y as f32) + 0.5 + jitter;
            seen[ids[i] as usize] += 1;
            let expected = if ids[i] == 0 {
                assert_eq!(depth[i], f32::INFINITY);
                let direction = unproject(&camera, centre, 1.0, SIZE) - pose.eye;
                project(&prev_camera, direction.extend(0.0), SIZE).truncate() - centre
            } else {
                let node = scene.instances[ids[i] as usize - 1].node;
                let world = unproject(&camera, centre, depth[i], SIZE);
                let to_prev: Affine3A = before.world_from_node[node] * now.world_from_node[node].inverse();
                let prev = project(&prev_camera, to_prev.transform_point3(world).extend(1.0), SIZE);
                let found = half(motion[i][2]);
                assert!((found - (prev.z - depth[i])).abs() < 2e-3, "depth change {found} at {x} {y}");
                prev.truncate() - centre
            };
            let found = Vec2::new(half(motion[i][0]), half(motion[i][1]));
            // Half floats have 11 bits: some pixels of motion are exact to a few thousandths.
            assert!(
                found.distance(expected) < 0.01,
                "{found} instead of {expected} at {x} {y}, id {}",
                ids[i]
            );
        }
    }
    assert!(seen.iter().all(|&count| count > 50), "not everything was in view: {seen:?}");
}

fn unproject(camera: &quell::Camera, pixel: Vec2, depth: f32, size: u32) -> Vec3 {
    let ndc = (pixel / size as f32 * 2.0 - 1.0) * Vec2::new(1.0, -1.0);
    let p = camera.clip_from_view;
    let view = Vec3::new(ndc.x / p.x_axis.x, ndc.y / p.y_axis.y, -1.0) * depth;
    camera.view_from_world.inverse().transform_point3(view)
}

/// Position in pixels, and view depth.
fn project(camera: &quell::Camera, world: Vec4, size: u32) -> Vec3 {
    let clip = camera.clip_from_view * camera.view_from_world * world;
    let uv = Vec2::new(clip.x, -clip.y) / clip.w * 0.5 + 0.5;
    (uv * size as f32).extend(clip.w)
}

#[test]
fn a_miss_and_a_hit_hold_what_the_denoiser_expects() {
    const SIZE: u32 = 32;
    let mut scene = moving_scene();
    scene.sky = Sky::constant(vec3(0.25, 0.5, 0.75));
    let pose = look_at(vec3(0.0, 1.0, 3.0), vec3(0.0, 0.8, 0.0), 0.9);
    let out =
        trace(&scene, &still(&pose, SIZE, 0.0), &TraceSettings { spp: 3.0, ..Default::default() }, SIZE);
    let ids = read::<u32>(&out.surface_id);
    let albedo = read::<[u16; 4]>(&out.albedo);
    let normal = read::<[u16; 4]>(&out.normal_roughness);
    let radiance = read::<[f32; 4]>(&out.radiance);
    assert!(read::<u32>(&out.sample_count).iter().all(|&n| n == 3));
    assert!(read::<[u16; 4]>(&out.motion).iter().all(|m| m[..2].iter().all(|&v| half(v).abs() < 1e-3)));
    for i in 0..ids.len() {
        let n = Vec3::from([0, 1, 2].map(|c| half(normal[i][c])));
        if ids[i] == 0 {
            assert_eq!((half(albedo[i][0]), n), (1.0, Vec3::ZERO));
            let off = Vec3::from_slice(&radiance[i]) - vec3(0.25, 0.5, 0.75);
            assert!(off.length() < 1e-5, "sky differs by {off}");
        } else {
            assert!((n.length() - 1.0).abs() < 2e-3);
            assert!((half(albedo[i][0]) - 0.8).abs() < 1e-3 && (half(normal[i][3]) - 0.8).abs() < 1e-3);
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_frame() {
    let (scene, pose) = lit_box();
    let settings = |frame, seed| TraceSettings { frame, seed, ..Default::default() };
    let frame = |settings| read::<[f32; 4]>(&trace(&scene, &still(&pose, 16, 0.0), &settings, 16).radiance);
    let first = frame(settings(5, 9));
    assert_eq!(first, frame(settings(5, 9)));
    assert_ne!(first, frame(settings(6, 9)));
    assert_ne!(first, frame(settings(5, 10)));
}

#[test]
fn a_lamp_that_is_off_is_dark() {
    let (mut scene, pose) = lit_box();
    let lamp = scene.materials.iter().position(Material::is_emissive).expect("the box has a lamp");
    scene.materials[lamp].emission_scale = Some(scenes::switch(1.0));
    let total = |time| {
        let out = trace(&scene, &still(&pose, 16, time), &TraceSettings::default(), 16);
        read::<[f32; 4]>(&out.radiance).iter().map(|p| p[0] + p[1] + p[2]).sum::<f32>()
    };
    assert!(total(0.5) > 1.0);
    assert_eq!(total(1.5), 0.0);
    assert!(total(2.5) > 1.0);
}
