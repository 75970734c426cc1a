//! The same scene, written down as other renderers do, gives the same image.

use crate::gpu::{depth_buffer, upload};
use crate::sequence::{Frame, camera, denoiser, jittered_frame, psnr, read_output, submit, with};
use glam::{
    Mat3, Mat4, Vec2, Vec3, Vec4,
    camera::rh::proj::directx::{perspective, perspective_infinite, perspective_infinite_reverse},
};
use quell::{
    Camera, Conventions, DepthEncoding, Handedness, HistoryMode, MotionDirection, MotionUnit, NormalEncoding,
    NormalSpace, Settings,
};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [96, 72];
const NEAR: f32 = 0.1;
const FAR: f32 = 100.0;
/// Depths and normals come out rounded otherwise by a unit in the last place, and seldom across a step of the guide.
const ALIKE_DB: f64 = 90.0;
/// What is taken for another convention comes out otherwise in more than some pixels.
const UNLIKE_DB: f64 = 70.0;

/// A walk with jitter.
fn walk() -> Vec<Frame> {
    let jitters = [[0.25, -0.15], [-0.35, 0.3], [0.1, -0.4], [-0.05, 0.2]].map(Vec2::from);
    let eye = |i: usize| Vec3::new(0.02, 0.01, -0.05) * i as f32 + Vec3::new(0.0, 1.4, 1.0);
    let frame = |i: usize| jittered_frame(SIZE, eye(i), eye(i.saturating_sub(1)), i as u64, jitters[i]);
    (0..jitters.len()).map(frame).collect()
}

/// What of a frame is written down otherwise.
#[derive(Default)]
struct Rewritten {
    depth: Option<wgpu::TextureView>,
    motion: Option<wgpu::TextureView>,
    normal: Option<wgpu::TextureView>,
    roughness: Option<wgpu::TextureView>,
    camera: Option<Camera>,
}

/// The last frame of the walk. `rewrite` gets each frame and the one before.
fn denoised(conventions: Conventions, rewrite: impl Fn(&Frame, &Frame) -> Rewritten) -> Vec<[f32; 3]> {
    let frames = walk();
    let settings = Settings::default().with_conventions(conventions);
    let mut quell = denoiser(SIZE);
    let mut output = vec![];
    for (i, frame) in frames.iter().enumerate() {
        let images = frame.upload();
        let rewritten = rewrite(frame, &frames[i.saturating_sub(1)]);
        let inputs = images.inputs(frame.camera, HistoryMode::Continue);
        let inputs = with(inputs, |inputs| {
            inputs.depth = rewritten.depth.as_ref().unwrap_or(inputs.depth);
            inputs.motion = rewritten.motion.as_ref().unwrap_or(inputs.motion);
            inputs.normal_roughness = rewritten.normal.as_ref().unwrap_or(inputs.normal_roughness);
            inputs.roughness = rewritten.roughness.as_ref();
            inputs.camera = rewritten.camera.unwrap_or(inputs.camera);
        });
        submit(&mut quell, &inputs, &settings);
        output = read_output(&images.output);
    }
    output
}

/// Demands the image that it should be, and another one where the conventions are `mistaken` for those.
fn check(
    name: &str,
    conventions: Conventions,
    mistaken: Option<Conventions>,
    rewrite: impl Fn(&Frame, &Frame) -> Rewritten,
) {
    let wanted = denoised(Conventions::default(), |_, _| Rewritten::default());
    let found = psnr(&denoised(conventions, &rewrite), &wanted);
    println!("{name}: {found:.1} dB");
    assert!(found > ALIKE_DB, "{name}: {found:.1} dB");
    if let Some(mistaken) = mistaken {
        let mistaken = psnr(&denoised(mistaken, &rewrite), &wanted);
        println!("{name}, mistaken: {mistaken:.1} dB");
        assert!(mistaken < UNLIKE_DB, "{name} is not told apart: {mistaken:.1} dB");
    }
}

/// View-space positions of what is seen, none for the sky.
fn positions(frame: &Frame) -> Vec<Option<Vec3>> {
    let [width, height] = frame.size.map(|side| side as f32);
    let view_from_clip = frame.camera.clip_from_view.inverse();
    let position = |(i, &depth): (usize, &f32)| {
        let pixel = Vec2::new((i % frame.size[0] as usize) as f32, (i / frame.size[0] as usize) as f32);
        let uv = (pixel + 0.5 + frame.camera.jitter_px) / Vec2::new(width, height);
        let ray = view_from_clip.project_point3(Vec3::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.5));
        depth.is_finite().then(|| ray * (depth / -ray.z))
    };
    frame.depth.iter().enumerate().map(position).collect()
}

fn image(format: Format, texels: &[impl bytemuck::Pod]) -> Option<wgpu::TextureView> {
    Some(upload(SIZE, format, texels))
}

#[test]
fn depth_may_be_the_distance_along_the_ray() {
    let conventions = Conventions::default().with_depth(DepthEncoding::Distance);
    check("distance", conventions, Some(Conventions::default()), |frame, _| {
        let distances: Vec<f32> =
            positions(frame).iter().map(|p| p.map_or(f32::INFINITY, Vec3::length)).collect();
        Rewritten { depth: image(Format::R32Float, &distances), ..Rewritten::default() }
    });
}

#[test]
fn depth_may_be_what_a_depth_buffer_holds() {
    let aspect = SIZE[0] as f32 / SIZE[1] as f32;
    let forward = perspective(1.0, aspect, NEAR, FAR);
    let swap =
        Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::new(0.0, 0.0, -1.0, 0.0), Vec4::new(0.0, 0.0, 1.0, 1.0));
    let projections = [
        ("forward", forward, 1.0),
        ("reverse-Z", swap * forward, 0.0),
        ("infinite", perspective_infinite(1.0, aspect, NEAR), 1.0),
        ("infinite reverse-Z", perspective_infinite_reverse(1.0, aspect, NEAR), 0.0),
    ];
    let conventions = Conventions::default().with_depth(DepthEncoding::Hardware);
    for (name, clip_from_view, cleared) in projections {
        for format in [Format::R32Float, Format::Depth32Float] {
            // Of a buffer of depth the format alone tells.
            let mistaken = (format == Format::R32Float).then(Conventions::default);
            check(name, conventions, mistaken, |frame, _| {
                let project = |p: &Option<Vec3>| p.map_or(cleared, |p| clip_from_view.project_point3(p).z);
                let stored: Vec<f32> = positions(frame).iter().map(project).collect();
                let depth = match format {
                    Format::R32Float => image(format, &stored),
                    _ => Some(depth_buffer(SIZE, format, &stored)),
                };
                let camera = Some(Camera { clip_from_view, ..frame.camera });
                Rewritten { depth, camera, ..Rewritten::default() }
            });
        }
    }
}

/// Rewrites motion, given that in UV to the previous frame and the jitters of this frame and the one before.
fn check_motion(name: &str, conventions: Conventions, rewrite: impl Fn(Vec2, [Vec2; 2]) -> Vec2) {
    check(name, conventions, Some(Conventions::default()), |frame, previous| {
        let jitters = [frame.camera.jitter_px, previous.camera.jitter_px];
        let motion: Vec<[f32; 2]> =
            frame.motion.iter().map(|&uv| rewrite(uv.into(), jitters).to_array()).collect();
        Rewritten { motion: image(Format::Rg32Float, &motion), ..Rewritten::default() }
    });
}

#[test]
fn motion_may_have_another_unit_and_direction() {
    let default = Conventions::default();
    let size = Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
    let from_previous = default.with_motion_direction(MotionDirection::FromPrevious);
    check_motion("pixels", default.with_motion_unit(MotionUnit::Pixels), |uv, _| uv * size);
    check_motion("NDC", default.with_motion_unit(MotionUnit::Ndc), |uv, _| uv * Vec2::new(2.0, -2.0));
    let scaled = MotionUnit::Scaled([0.5, -0.25]);
    check_motion("scaled", default.with_motion_unit(scaled), |uv, _| uv / Vec2::new(0.5, -0.25));
    check_motion("from previous", from_previous, |uv, _| -uv);
    check_motion("from previous, NDC", from_previous.with_motion_unit(MotionUnit::Ndc), |uv, _| {
        uv * Vec2::new(-2.0, 2.0)
    });
}

#[test]
fn motion_may_have_the_jitter_in_it() {
    let conventions = Conventions::default().with_motion_is_jittered(true);
    let size = Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
    // A jittered projection shows a point that much towards the other side.
    check_motion("jittered", conventions, |uv, [now, before]| uv + (now - before) / size);
    let from_previous = conventions.with_motion_direction(MotionDirection::FromPrevious);
    check_motion("jittered, from previous", from_previous, |uv, [now, before]| (before - now) / size - uv);
}

/// What lies in z of motion that tells nothing of depth is not looked at.
#[test]
fn motion_may_have_something_else_in_z() {
    let conventions = Conventions::default().with_motion_has_depth(false);
    check("without depth", conventions, Some(Conventions::default()), |frame, _| {
        let motion: Vec<[f32; 4]> = frame.motion.iter().map(|&[x, y]| [x, y, 3.0, 1.0]).collect();
        Rewritten { motion: image(Format::Rgba32Float, &motion), ..Rewritten::default() }
    });
}

/// The change of depth counts in the direction of the motion.
#[test]
fn motion_from_the_previous_frame_holds_for_depth() {
    let conventions = Conventions::default().with_motion_direction(MotionDirection::FromPrevious);
    check("depth from previous", conventions, Some(Conventions::default()), |frame, previous| {
        let world_from_view = frame.camera.view_from_world.inverse();
        let depth_before = |p: Vec3| {
            -previous.camera.view_from_world.transform_point3(world_from_view.transform_point3(p)).z
        };
        let motion: Vec<[f32; 4]> = (frame.motion.iter().zip(positions(frame)))
            .map(|(&[x, y], p)| [-x, -y, p.map_or(0.0, |p| -p.z - depth_before(p)), 1.0])
            .collect();
        Rewritten { motion: image(Format::Rgba32Float, &motion), ..Rewritten::default() }
    });
}

fn check_normals<const N: usize>(
    name: &str,
    format: Format,
    [conventions, mistaken]: [Conventions; 2],
    rewrite: impl Fn(Vec3) -> [f32; N],
) where
    [half::f16; N]: bytemuck::Pod,
{
    check(name, conventions, Some(mistaken), |frame, _| {
        let normals: Vec<[half::f16; N]> = (frame.normal.iter())
            .map(|&[x, y, z, _]| rewrite(Vec3::new(x, y, z)).map(half::f16::from_f32))
            .collect();
        let roughness: Vec<f32> = frame.normal.iter().map(|normal| normal[3]).collect();
        Rewritten {
            normal: image(format, &normals),
            roughness: image(Format::R32Float, &roughness),
            ..Rewritten::default()
        }
    });
}

/// Written anew from the paper (Cigolle et al. 2014, section 3).
fn octahedral(n: Vec3) -> [f32; 2] {
    let p = n / (n.x.abs() + n.y.abs() + n.z.abs()).max(1e-6);
    let fold = |a: f32, b: f32| (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 };
    if p.z >= 0.0 { [p.x, p.y] } else { [fold(p.x, p.y), fold(p.y, p.x)] }
}

#[test]
fn normals_may_be_encoded() {
    use NormalEncoding::{Octahedral, OctahedralUnsigned, Signed, Unsigned};
    let not = |encodings: [NormalEncoding; 2]| {
        encodings.map(|encoding| Conventions::default().with_normal_encoding(encoding))
    };
    let unsigned = |v: f32| 0.5 + 0.5 * v;
    check_normals("unsigned", Format::Rgba16Float, not([Unsigned, Signed]), |n| {
        let [x, y, z] = n.to_array().map(unsigned);
        [x, y, z, 0.0]
    });
    let octahedrals = [Octahedral, OctahedralUnsigned];
    check_normals("octahedral", Format::Rg16Float, not(octahedrals), octahedral);
    let unsigned_octahedrals = [OctahedralUnsigned, Octahedral];
    check_normals("octahedral, unsigned", Format::Rg16Float, not(unsigned_octahedrals), |n| {
        octahedral(n).map(unsigned)
    });
}

#[test]
fn normals_may_be_in_view_space() {
    let view = Mat3::from_mat4(camera(Vec3::ZERO, SIZE).view_from_world);
    let spaces = [NormalSpace::View, NormalSpace::World];
    let conventions = spaces.map(|space| Conventions::default().with_normal_space(space));
    check_normals("view space", Format::Rgba16Float, conventions, |n| (view * n).extend(1.0).to_array());
}

#[test]
fn cameras_may_look_along_positive_z() {
    let flip = Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0));
    let conventions = Conventions::default().with_handedness(Handedness::Left);
    let left_handed = |camera: Camera| Camera {
        view_from_world: flip * camera.view_from_world,
        clip_from_view: camera.clip_from_view * flip,
        ..camera
    };
    check("left-handed", conventions, None, |frame, _| Rewritten {
        camera: Some(left_handed(frame.camera)),
        ..Rewritten::default()
    });
    // With all that depends on it; normals taken for those of a right-handed view would be mirrored.
    let all = conventions.with_normal_space(NormalSpace::View).with_depth(DepthEncoding::Hardware);
    let mistaken = all.with_normal_space(NormalSpace::World);
    check("left-handed view space", all, Some(mistaken), |frame, _| {
        let camera = left_handed(frame.camera);
        let view = Mat3::from_mat4(camera.view_from_world);
        let normals: Vec<[f32; 4]> = (frame.normal.iter())
            .map(|&[x, y, z, roughness]| (view * Vec3::new(x, y, z)).extend(roughness).to_array())
            .collect();
        let project = |p: &Option<Vec3>| {
            p.map_or(1.0, |p| camera.clip_from_view.project_point3(Vec3::new(p.x, p.y, -p.z)).z)
        };
        let stored: Vec<f32> = positions(frame).iter().map(project).collect();
        Rewritten {
            camera: Some(camera),
            normal: image(Format::Rgba32Float, &normals),
            depth: image(Format::R32Float, &stored),
            ..Rewritten::default()
        }
    });
}
