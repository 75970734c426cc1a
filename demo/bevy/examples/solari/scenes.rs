//! Two scenes, and where their camera and what moves in them are at a time.

use bevy::asset::RenderAssetUsages;
use bevy::camera::Exposure;
use bevy::image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy::solari::prelude::RaytracingMesh3d;
use std::f32::consts::{FRAC_PI_2, PI};

/// `WxH`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let number = |text: &str| text.parse().ok().filter(|number| *number > 0);
    let size = text.split_once('x').and_then(|(width, height)| Some([number(width)?, number(height)?]));
    size.ok_or_else(|| "expected a width and a height, as in 1280x720".into())
}

/// What is walked through.
#[derive(clap::ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scene {
    /// A room under a lamp: textures, boxes, a rough and a glossy ball.
    Room,
    /// A court in the sun: columns, coloured lamps in their shade, a cart that moves.
    Court,
}

/// What moves by itself.
#[derive(Component)]
pub struct Cart;

impl Scene {
    pub fn exposure(self) -> Exposure {
        match self {
            Self::Room => Exposure::INDOOR,
            Self::Court => Exposure { ev100: 13.0 },
        }
    }

    /// The camera after so many frames, at 60 a second.
    pub fn camera(self, frame: f32) -> Transform {
        let t = frame / 60.0;
        match self {
            Self::Room => Transform::from_xyz(-0.9 + 0.9 * t, 1.4, 3.4 - 0.6 * t)
                .looking_at(Vec3::new(0.2 * t, 1.0, -1.0), Vec3::Y),
            Self::Court => Transform::from_xyz(-2.6 + 1.5 * t, 1.7, 4.2)
                .looking_at(Vec3::new(-0.6 + t, 1.1, -1.5), Vec3::Y),
        }
    }

    /// The cart then, in the court.
    pub fn cart(self, frame: f32) -> Transform {
        Transform::from_xyz(-1.5 + 2.0 * frame / 60.0, 0.4, 0.8)
    }

    pub fn spawn(self, world: &mut World) {
        match self {
            Self::Room => room(world),
            Self::Court => court(world),
        }
    }
}

fn room(world: &mut World) {
    let checker = checker(world);
    let wall = |r, g, b| StandardMaterial { perceptual_roughness: 0.9, ..colour(r, g, b) };
    let floor = StandardMaterial {
        base_color_texture: Some(checker),
        perceptual_roughness: 0.6,
        ..colour(0.8, 0.8, 0.8)
    };
    let lamp =
        StandardMaterial { emissive: LinearRgba::rgb(9000.0, 8200.0, 7000.0), ..colour(0.8, 0.8, 0.8) };
    let plane = |size| Mesh::from(Plane3d::default().mesh().size(size, size));
    let at = Transform::from_xyz;
    put(world, plane(4.0), floor, Transform::IDENTITY);
    put(
        world,
        plane(4.0),
        wall(0.75, 0.75, 0.75),
        at(0.0, 3.0, 0.0).with_rotation(Quat::from_rotation_x(PI)),
    );
    put(
        world,
        plane(4.0),
        wall(0.75, 0.75, 0.75),
        at(0.0, 1.0, -2.0).with_rotation(Quat::from_rotation_x(FRAC_PI_2)),
    );
    put(
        world,
        plane(4.0),
        wall(0.6, 0.1, 0.08),
        at(-2.0, 1.0, 0.0).with_rotation(Quat::from_rotation_z(-FRAC_PI_2)),
    );
    put(
        world,
        plane(4.0),
        wall(0.12, 0.4, 0.12),
        at(2.0, 1.0, 0.0).with_rotation(Quat::from_rotation_z(FRAC_PI_2)),
    );
    put(world, plane(1.0), lamp, at(0.0, 2.98, -0.3).with_rotation(Quat::from_rotation_x(PI)));
    let block = Mesh::from(Cuboid::new(0.9, 1.7, 0.9));
    put(world, block, wall(0.7, 0.7, 0.65), at(-0.8, 0.85, -0.8).with_rotation(Quat::from_rotation_y(0.4)));
    let ball = |radius| Sphere::new(radius).mesh().uv(48, 24);
    let metal = |perceptual_roughness, base: StandardMaterial| StandardMaterial {
        metallic: 1.0,
        perceptual_roughness,
        ..base
    };
    put(world, ball(0.5), metal(0.25, colour(0.9, 0.7, 0.4)), at(0.8, 0.5, -0.3));
    put(
        world,
        ball(0.35),
        StandardMaterial { perceptual_roughness: 0.4, ..colour(0.1, 0.25, 0.7) },
        at(0.1, 0.35, 0.5),
    );
}

fn court(world: &mut World) {
    let checker = checker(world);
    let stone = || StandardMaterial { perceptual_roughness: 0.8, ..colour(0.6, 0.55, 0.47) };
    let ground = StandardMaterial {
        base_color_texture: Some(checker),
        perceptual_roughness: 0.8,
        ..colour(0.7, 0.7, 0.68)
    };
    let lamp =
        |r, g, b| StandardMaterial { emissive: LinearRgba::rgb(r, g, b) * 40_000.0, ..colour(0.8, 0.8, 0.8) };
    let at = Transform::from_xyz;
    let cuboid = |x, y, z| Mesh::from(Cuboid::new(x, y, z));
    put(world, Plane3d::default().mesh().size(24.0, 24.0).into(), ground, Transform::IDENTITY);
    put(world, cuboid(12.0, 5.0, 0.4), stone(), at(0.0, 2.5, -3.5));
    put(world, cuboid(12.0, 0.3, 3.5), stone(), at(0.0, 3.6, -1.9));
    for i in 0..7 {
        let x = -4.8 + 1.6 * i as f32;
        put(world, Cylinder::new(0.22, 3.45).mesh().resolution(32).into(), stone(), at(x, 1.725, -0.5));
    }
    put(world, cuboid(0.4, 0.8, 0.4), lamp(1.0, 0.3, 0.1), at(-2.6, 0.4, -2.6));
    put(world, cuboid(0.4, 0.8, 0.4), lamp(0.1, 0.4, 1.0), at(1.2, 0.4, -2.6));
    let red = StandardMaterial { perceptual_roughness: 0.5, ..colour(0.7, 0.12, 0.1) };
    let cart = put(world, cuboid(1.0, 0.8, 0.6), red, Transform::IDENTITY);
    world.entity_mut(cart).insert(Cart);
    let sun = DirectionalLight { illuminance: 60_000.0, shadow_maps_enabled: false, ..default() };
    world.spawn((sun, Transform::default().looking_to(Vec3::new(0.8, -1.0, -0.6), Vec3::Y)));
}

fn colour(r: f32, g: f32, b: f32) -> StandardMaterial {
    StandardMaterial { base_color: Color::linear_rgb(r, g, b), ..default() }
}

fn put(world: &mut World, mesh: Mesh, material: StandardMaterial, transform: Transform) -> Entity {
    let mesh = mesh.with_generated_tangents().expect("these meshes have normals and UVs");
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(material);
    // Both are needed: one is drawn into the G-buffer, the other one is what rays hit.
    let meshes = (Mesh3d(mesh.clone()), RaytracingMesh3d(mesh));
    world.spawn((meshes, MeshMaterial3d(material), transform)).id()
}

/// Squares of two greys, eight to a side.
fn checker(world: &mut World) -> Handle<Image> {
    let texel =
        |i: u32| if (i / 8 + i % 8).is_multiple_of(2) { [235, 230, 220, 255] } else { [120, 115, 110, 255] };
    let texels = (0..64).flat_map(texel).collect();
    let size = Extent3d { width: 8, height: 8, depth_or_array_layers: 1 };
    let (dimension, format) = (TextureDimension::D2, TextureFormat::Rgba8UnormSrgb);
    let mut image = Image::new(size, dimension, texels, format, RenderAssetUsages::RENDER_WORLD);
    let address = ImageAddressMode::Repeat;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: address,
        address_mode_v: address,
        ..ImageSamplerDescriptor::nearest()
    });
    world.resource_mut::<Assets<Image>>().add(image)
}
