//! What `demo/bevy` needs no bevy for: that it reads bevy's G-buffer and knows what bevy's numbers mean. Bevy's formulas are written
//! here once more, from its documentation.

#[path = "../../demo/bevy/src/conventions.rs"]
mod conventions;
#[path = "../../demo/bevy/src/decode.rs"]
mod decode;

use crate::gpu::{depth_buffer, download, gpu, upload};
use conventions::{camera, conventions};
use decode::{DecodeFrame, Decoded, Decoder};
use glam::{Mat4, Quat, Vec2, Vec3, Vec4, vec2, vec3};
use half::f16;
use quell::{MotionDirection, Viewport};
use wgpu::TextureFormat;

const NEAR: f32 = 0.1;
const SIZE: [u32; 2] = [13, 9];

/// Bevy's perspective: infinite, reverse-Z.
fn clip_from_view() -> Mat4 {
    Mat4::from_cols(
        Vec4::new(1.1, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 1.7, 0.0, 0.0),
        Vec4::new(0.0, 0.0, 0.0, -1.0),
        Vec4::new(0.0, 0.0, NEAR, 0.0),
    )
}

/// What a material writes into bevy's G-buffer.
#[derive(Clone, Copy)]
struct Surface {
    base: Vec3,
    roughness: f32,
    emission: Vec3,
    normal: Vec3,
    view_depth: f32,
}

impl Surface {
    /// A different one at each pixel.
    fn of_pixel(i: u32) -> Self {
        let f = i as f32 / (SIZE[0] * SIZE[1]) as f32;
        let normal = vec3((9.0 * f).sin(), (23.0 * f).cos(), (5.0 * f).sin() - 0.3).normalize();
        Self {
            base: vec3(f, 1.0 - f, 0.5 * f),
            roughness: f,
            emission: vec3(3000.0 * f, 0.25, (40.0 * f).exp2() / 1e9),
            normal,
            view_depth: 0.2 + 50.0 * f * f,
        }
    }

    fn gbuffer(self) -> [u32; 4] {
        let unorm8 = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u32;
        let gamma = self.base.to_array().map(|v| unorm8(v.powf(1.0 / 2.2)));
        let colour = gamma[0] | gamma[1] << 8 | gamma[2] << 16 | unorm8(self.roughness) << 24;
        // Reflectance 0.5, no metal, no occlusion, no clearcoat.
        let properties = 128 | 255 << 16;
        [colour, rgb9e5(self.emission), properties, octahedral24(self.normal) | 5 << 24]
    }
}

/// EXT_texture_shared_exponent.
fn rgb9e5(rgb: Vec3) -> u32 {
    let largest = rgb.max_element();
    let exponent = largest.log2().floor().max(-16.0) as i32 + 16;
    let scale = f32::powi(2.0, exponent - 24);
    let [r, g, b] = rgb.to_array().map(|v| ((v / scale + 0.5) as u32).min(511));
    r | g << 9 | b << 18 | (exponent as u32) << 27
}

fn octahedral24(n: Vec3) -> u32 {
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
    let e = if n.z >= 0.0 {
        vec2(n.x, n.y)
    } else {
        vec2((1.0 - n.y.abs()) * sign(n.x), (1.0 - n.x.abs()) * sign(n.y))
    };
    let [x, y] = (e * 0.5 + 0.5).to_array().map(|v| (v * 4095.0 + 0.5) as u32);
    x | y << 12
}

/// What came of a G-buffer: albedo, normal and roughness, depth, emission.
struct Texels {
    albedo: Vec<[u8; 4]>,
    normal_roughness: Vec<[f16; 4]>,
    depth: Vec<f32>,
    emission: Vec<[f16; 4]>,
}

fn decode(gbuffer: &[[u32; 4]], depth: &[f32], frame: &DecodeFrame) -> Texels {
    let gpu = gpu();
    let gbuffer = upload(SIZE, TextureFormat::Rgba32Uint, gbuffer);
    let depth = depth_buffer(SIZE, TextureFormat::Depth32Float, depth);
    let decoded = Decoded::new(&gpu.device, SIZE);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let device = (&gpu.device, &gpu.queue);
    Decoder::new(&gpu.device).record(device, &mut encoder, [&gbuffer, &depth], frame, &decoded);
    gpu.queue.submit([encoder.finish()]);
    assert_eq!(decoded.size(), SIZE);
    Texels {
        albedo: download(&decoded.albedo),
        normal_roughness: download(&decoded.normal_roughness),
        depth: download(&decoded.depth),
        emission: download(&decoded.emission),
    }
}

fn whole_frame() -> DecodeFrame {
    DecodeFrame {
        clip_from_view: clip_from_view().to_cols_array(),
        viewport: Viewport::of_size(SIZE[0], SIZE[1]),
        emission_scale: 0.5,
        has_albedo: true,
    }
}

fn surfaces() -> Vec<Surface> {
    (0..SIZE[0] * SIZE[1]).map(Surface::of_pixel).collect()
}

fn reverse_z(view_depth: f32) -> f32 {
    NEAR / view_depth
}

fn close(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance
}

#[test]
fn a_gbuffer_of_bevy_is_read() {
    let surfaces = surfaces();
    let gbuffer: Vec<_> = surfaces.iter().map(|surface| surface.gbuffer()).collect();
    let depth: Vec<_> = surfaces.iter().map(|surface| reverse_z(surface.view_depth)).collect();
    let texels = decode(&gbuffer, &depth, &whole_frame());
    for (i, surface) in surfaces.iter().enumerate() {
        for c in 0..3 {
            let albedo = f32::from(texels.albedo[i][c]) / 255.0;
            // Half a step of the output, and of the input where the slope is steepest.
            assert!(close(albedo, surface.base[c], 0.5 / 255.0 + 2.2 * 0.5 / 255.0 + 1e-4), "albedo {i} {c}");
            let emission = texels.emission[i][c].to_f32();
            let step = 0.5 * surface.emission.max_element() / 256.0;
            assert!(close(emission, 0.5 * surface.emission[c], step + 1e-5), "emission {i} {c}: {emission}");
        }
        let [x, y, z, roughness] = texels.normal_roughness[i].map(f16::to_f32);
        // A step of 12 bits, and one of half floats in each component.
        let off = vec3(x, y, z).distance(surface.normal);
        assert!(off < 1.0 / 2048.0 + 1e-3, "normal {i}: {x} {y} {z}, {}", surface.normal);
        assert!(close(roughness, surface.roughness, 0.5 / 255.0 + 1e-3), "roughness {i}");
        assert!(close(texels.depth[i] / surface.view_depth, 1.0, 1e-5), "depth {i}");
    }
}

/// A finite reverse-Z projection and an orthographic one store other depths for the same surfaces.
#[test]
fn depth_is_read_by_the_projection() {
    let surfaces = surfaces();
    let gbuffer: Vec<_> = surfaces.iter().map(|surface| surface.gbuffer()).collect();
    let (near, far) = (NEAR, 80.0);
    let with_depth_rows = |a: f32, b: f32, c: f32, d: f32| {
        let mut clip = clip_from_view();
        (clip.z_axis.z, clip.w_axis.z, clip.z_axis.w, clip.w_axis.w) = (a, b, c, d);
        clip
    };
    let projections = [
        with_depth_rows(near / (far - near), near * far / (far - near), -1.0, 0.0),
        with_depth_rows(1.0 / (far - near), far / (far - near), 0.0, 1.0),
    ];
    for clip in projections {
        let stored = |surface: &Surface| {
            let clip = clip * Vec4::new(0.0, 0.0, -surface.view_depth, 1.0);
            clip.z / clip.w
        };
        let depth: Vec<_> = surfaces.iter().map(stored).collect();
        let frame = DecodeFrame { clip_from_view: clip.to_cols_array(), ..whole_frame() };
        let texels = decode(&gbuffer, &depth, &frame);
        for (read, surface) in texels.depth.iter().zip(&surfaces) {
            assert!(close(*read / surface.view_depth, 1.0, 1e-4), "{read}, {}", surface.view_depth);
        }
    }
}

#[test]
fn what_has_no_noise_is_a_miss() {
    let surface = Surface::of_pixel(20);
    let mut gbuffer = vec![surface.gbuffer(); surfaces().len()];
    let mut depth = vec![reverse_z(surface.view_depth); gbuffer.len()];
    // Sky; something that was drawn forward, with depth but no G-buffer: what bevy clears it to.
    let cleared = [0, 0, 0, 1];
    (gbuffer[1], depth[1]) = (cleared, 0.0);
    gbuffer[2] = cleared;
    let texels = decode(&gbuffer, &depth, &whole_frame());
    assert!(close(texels.depth[0], surface.view_depth, 1e-4));
    assert_eq!(texels.depth[1..3], [0.0, 0.0]);
}

#[test]
fn incident_light_has_neither_albedo_nor_emission() {
    let surface = Surface::of_pixel(60);
    let gbuffer = vec![surface.gbuffer(); surfaces().len()];
    let depth = vec![reverse_z(surface.view_depth); gbuffer.len()];
    let frame = DecodeFrame { emission_scale: 0.0, has_albedo: false, ..whole_frame() };
    let texels = decode(&gbuffer, &depth, &frame);
    assert!(texels.albedo.iter().all(|texel| *texel == [255; 4]));
    assert!(texels.emission.iter().all(|texel| texel[..3].iter().all(|v| v.to_f32() == 0.0)));
}

#[test]
fn a_viewport_is_read_where_it_lies() {
    let surface = Surface::of_pixel(60);
    let gbuffer = vec![surface.gbuffer(); surfaces().len()];
    let depth = vec![reverse_z(surface.view_depth); gbuffer.len()];
    let viewport = Viewport { origin: [3, 2], size: [7, 5] };
    let texels = decode(&gbuffer, &depth, &DecodeFrame { viewport, ..whole_frame() });
    for (i, depth) in (0..).zip(&texels.depth) {
        let (x, y) = (i % SIZE[0], i / SIZE[0]);
        let is_inside = (3..10).contains(&x) && (2..7).contains(&y);
        assert_eq!(*depth != 0.0, is_inside, "{x}, {y}");
    }
}

fn world_from_view(t: f32) -> Mat4 {
    Mat4::from_rotation_translation(Quat::from_rotation_y(0.3 + 0.1 * t), vec3(0.2 * t, 1.0, 2.0))
}

/// UV, y down, of a point.
fn uv(clip_from_world: Mat4, point: Vec3) -> Vec2 {
    let clip = clip_from_world * point.extend(1.0);
    vec2(0.5, 0.5) + vec2(0.5, -0.5) * vec2(clip.x, clip.y) / clip.w
}

/// `calculate_motion_vector` of `bevy_pbr`: the difference of clip positions times (0.5, -0.5).
#[test]
fn motion_points_from_where_a_surface_was() {
    assert_eq!(conventions().motion_direction, MotionDirection::FromPrevious);
    let point = vec3(0.4, 0.7, -3.0);
    let [now, before] = [1.0, 0.0].map(|t| {
        let camera = camera(world_from_view(t).to_cols_array(), clip_from_view().to_cols_array(), [0.0; 2]);
        camera.clip_from_view * camera.view_from_world
    });
    let clip = |matrix: Mat4| {
        let clip = matrix * point.extend(1.0);
        vec2(clip.x, clip.y) / clip.w
    };
    let motion = (clip(now) - clip(before)) * vec2(0.5, -0.5);
    let previous = uv(now, point) - motion;
    assert!(previous.abs_diff_eq(uv(before, point), 1e-6) && motion.length() > 0.01, "{previous} {motion}");
}

/// `TemporalJitter::jitter_projection` adds `offset * (2, -2) / size` to the third column.
#[test]
fn jitter_is_where_the_sample_lies() {
    let offset = vec2(0.3, -0.2);
    let size = vec2(SIZE[0] as f32, SIZE[1] as f32);
    let jitter = offset * vec2(2.0, -2.0) / size;
    let mut jittered = clip_from_view();
    jittered.z_axis.x += jitter.x;
    jittered.z_axis.y += jitter.y;
    let world_from_view = world_from_view(0.0);
    let camera = camera(world_from_view.to_cols_array(), clip_from_view().to_cols_array(), offset.to_array());
    let point = world_from_view.transform_point3(vec3(0.3, -0.2, -4.0));
    // The pixel where the point is drawn has its sample at the point.
    let drawn = uv(jittered * world_from_view.inverse(), point) * size;
    let lies = uv(camera.clip_from_view * camera.view_from_world, point) * size;
    assert!((lies - drawn).abs_diff_eq(camera.jitter_px, 1e-4), "{} {}", lies - drawn, camera.jitter_px);
}
