//! The plugin in bevy apps without a window, on light that bevy's own renderer makes and a pass makes noisy.

#[path = "../../examples/solari/headless.rs"]
mod headless;
mod noise;
#[path = "../../examples/solari/picture.rs"]
#[expect(dead_code, reason = "the example writes pictures, too")]
mod picture;

use bevy::anti_alias::taa::TemporalAntiAliasing;
use bevy::camera::{CameraMainTextureUsages, Hdr, MainPassResolutionOverride, RenderTarget, Viewport};
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass};
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::diagnostic::{DiagnosticPath, DiagnosticsStore};
use bevy::pbr::DefaultOpaqueRendererMethod;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::diagnostic::RenderDiagnosticsPlugin;
use bevy::render::render_resource::{Extent3d, TextureFormat, TextureUsages};
use bevy::render::sync_world::RenderEntity;
use noise::{Noise, NoisePlugin};
use picture::Picture;
use quell_bevy::quell::{DebugView, Settings};
use quell_bevy::{
    Quell, QuellBudget, QuellImages, QuellLight, QuellPlugin, QuellSettings, QuellSignal, QuellView, Refusal,
};

const SIZE: [u32; 2] = [128, 72];

/// An app with a floor, a block, a lamp that glows and a light; and a camera that sees them.
struct Stage {
    app: App,
    camera: Entity,
    image: Handle<Image>,
}

impl Stage {
    fn new(components: impl Bundle) -> Self {
        let mut app = headless::app();
        app.add_plugins((QuellPlugin, NoisePlugin, RenderDiagnosticsPlugin));
        app.insert_resource(DefaultOpaqueRendererMethod::deferred());
        Self::begin(app, components)
    }

    fn begin(mut app: App, components: impl Bundle) -> Self {
        headless::begin(&mut app);
        let image = headless::image(&mut app, SIZE);
        let world = app.world_mut();
        let mut put = |mesh: Mesh, material, transform: Transform| {
            let mesh = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh));
            let material = MeshMaterial3d(world.resource_mut::<Assets<StandardMaterial>>().add(material));
            world.spawn((mesh, material, transform));
        };
        let colour = |r, g, b| StandardMaterial {
            base_color: Color::linear_rgb(r, g, b),
            perceptual_roughness: 0.9,
            ..default()
        };
        let lamp = StandardMaterial { emissive: LinearRgba::rgb(2.0, 1.5, 0.5), ..colour(0.5, 0.5, 0.5) };
        let at = Transform::from_xyz;
        put(Plane3d::default().mesh().size(9.0, 9.0).into(), colour(0.6, 0.5, 0.3), Transform::IDENTITY);
        put(Cuboid::new(1.0, 2.0, 1.0).into(), colour(0.2, 0.3, 0.7), at(-0.7, 1.0, 0.0));
        put(Cuboid::new(0.5, 0.5, 0.5).into(), lamp, at(1.0, 0.25, 0.3));
        let light = PointLight { intensity: 2e6, ..default() };
        world.spawn((light, at(2.0, 4.0, 3.0)));
        world.insert_resource(ClearColor(Color::BLACK));
        let camera = Self::spawn(world, &image, components);
        let mut stage = Self { app, camera, image };
        // Bevy takes some frames until all lights are there.
        stage.frames(8);
        stage
    }

    fn spawn(world: &mut World, image: &Handle<Image>, components: impl Bundle) -> Entity {
        let target = RenderTarget::from(image.clone());
        let linear = (Tonemapping::None, DebandDither::Disabled);
        let camera = world.spawn((Camera3d::default(), target, linear, Self::pose(0.0))).id();
        world.entity_mut(camera).insert(components);
        camera
    }

    fn pose(t: f32) -> Transform {
        Transform::from_xyz(0.3 * t, 1.8, 4.0).looking_at(Vec3::new(0.0, 0.6, 0.0), Vec3::Y)
    }

    fn frames(&mut self, count: u32) {
        for _ in 0..count {
            headless::update(&mut self.app).unwrap();
        }
    }

    /// Frames with a camera that moves, and ends where it began.
    fn moving_frames(&mut self, count: u32) {
        for i in (0..count).rev() {
            let pose = Self::pose((i as f32 * 0.05).sin());
            *self.camera().get_mut::<Transform>().unwrap() = pose;
            self.frames(1);
        }
    }

    fn camera(&mut self) -> EntityWorldMut<'_> {
        self.app.world_mut().entity_mut(self.camera)
    }

    fn quell(&mut self) -> Mut<'_, Quell> {
        self.app.world_mut().get_mut::<Quell>(self.camera).unwrap()
    }

    fn picture(&self) -> Picture {
        headless::read(&self.app, &self.image).unwrap()
    }

    fn render_entity(&self, camera: Entity) -> Option<Entity> {
        Some(**self.app.world().get::<RenderEntity>(camera)?)
    }

    fn view_of(&self, camera: Entity) -> Option<&QuellView> {
        self.app.sub_app(RenderApp).world().get::<QuellView>(self.render_entity(camera)?)
    }

    fn view(&self) -> &QuellView {
        self.view_of(self.camera).expect("the camera has quell")
    }

    fn refusal(&self) -> Option<Refusal> {
        self.view().outcome().expect("a frame was drawn").err()
    }

    fn restarted(&self) -> bool {
        self.view().outcome().unwrap().unwrap().restarted
    }
}

/// What a camera without quell needs, to draw deferred and in linear light.
fn drawn() -> impl Bundle {
    (Hdr, DeferredPrepass, DepthPrepass, Msaa::Off)
}

/// Noise, and the storage texture that it is written to, as Solari writes.
fn noisy() -> impl Bundle {
    (Noise, CameraMainTextureUsages::default().with(TextureUsages::STORAGE_BINDING))
}

/// What the stage looks like without noise.
fn clean() -> Picture {
    Stage::new(drawn()).picture()
}

/// Bevy's deferred lighting does not expose emission.
fn unexposed() -> Quell {
    Quell { light: QuellLight::Unexposed, ..default() }
}

fn psnr_db(image: &Picture, reference: &Picture) -> f64 {
    picture::psnr_db(image, reference).unwrap()
}

#[test]
fn noise_goes() {
    let clean = clean();
    let lit = clean.pixels.iter().filter(|pixel| pixel[0] > 0.05).count();
    assert!(lit > clean.pixels.len() / 4, "the stage is dark: {lit} pixels are lit");
    let without = Stage::new((drawn(), noisy()));
    let noise = psnr_db(&without.picture(), &clean);
    let mut stage = Stage::new((unexposed(), noisy()));
    stage.moving_frames(24);
    assert_eq!(stage.refusal(), None);
    let denoised = psnr_db(&stage.picture(), &clean);
    println!("{noise:.2} dB noisy, {denoised:.2} dB denoised");
    assert!(denoised > noise + 12.0, "{noise:.2} dB noisy, {denoised:.2} dB denoised");
}

#[test]
fn an_image_without_noise_stays_as_it_is() {
    let mut stage = Stage::new(unexposed());
    stage.frames(8);
    let psnr = psnr_db(&stage.picture(), &clean());
    assert!(psnr > 40.0, "{psnr:.2} dB");
}

#[test]
fn inputs_look_right_while_a_jittered_camera_moves() {
    let quell = Quell { check_inputs: true, ..unexposed() };
    let mut stage = Stage::new((quell, noisy(), TemporalAntiAliasing::default()));
    stage.moving_frames(40);
    assert_eq!(stage.refusal(), None);
    let findings: Vec<_> = stage.view().findings().iter().map(ToString::to_string).collect();
    assert!(findings.is_empty(), "{findings:#?}");
    // And all of it could be told but albedo, which needs more texture.
    let untold = stage.view().untold();
    assert!(untold.iter().all(|untold| untold.input == "albedo"), "{untold:#?}");
}

/// Not that of the deferred prepass: bevy 0.20.1 panics where it is removed while meshes are in view.
#[test]
fn a_missing_prepass_is_named() {
    let mut stage = Stage::new(unexposed());
    stage.frames(2);
    assert_eq!(stage.refusal(), None);
    stage.camera().remove::<MotionVectorPrepass>();
    stage.frames(2);
    assert_eq!(stage.refusal(), Some(Refusal::Prepass("MotionVectorPrepass")));
    let message = stage.refusal().unwrap().to_string();
    assert!(message.contains("MotionVectorPrepass") && message.contains("add it again"), "{message}");
    stage.camera().insert(MotionVectorPrepass);
    stage.frames(2);
    assert_eq!(stage.refusal(), None);
}

#[test]
fn a_target_that_holds_no_light_is_named() {
    let mut stage = Stage::new(unexposed());
    let (format, usage) = (TextureFormat::Rgba8UnormSrgb, TextureUsages::COPY_SRC);
    let image = headless::image_of(&mut stage.app, SIZE, format, usage);
    let target = (RenderTarget::from(image), CameraMainTextureUsages::default());
    stage.camera().insert(target).remove::<Hdr>();
    stage.frames(2);
    assert_eq!(stage.refusal(), Some(Refusal::NotHdr("Rgba8UnormSrgb".into())));
    stage.camera().insert(Hdr);
    stage.frames(2);
    assert_eq!(stage.refusal(), None);
}

#[test]
fn what_is_drawn_forward_is_told_and_passes_through() {
    let mut app = headless::app();
    app.add_plugins((QuellPlugin, NoisePlugin));
    let mut stage = Stage::begin(app, unexposed());
    assert_eq!((stage.refusal(), stage.view().draws_forward_only()), (None, true));
    let mut bare = Stage::begin(headless::app(), (Hdr, Msaa::Off));
    stage.frames(1);
    bare.frames(1);
    let psnr = psnr_db(&stage.picture(), &bare.picture());
    assert!(psnr > 60.0, "{psnr:.2} dB");
    let mut deferred = Stage::new(unexposed());
    deferred.frames(1);
    assert!(!deferred.view().draws_forward_only());
}

#[test]
fn history_is_kept_and_dropped() {
    let mut stage = Stage::new((unexposed(), noisy()));
    stage.frames(3);
    assert!(!stage.restarted());
    stage.quell().restart();
    stage.frames(1);
    assert!(stage.restarted());
    stage.frames(1);
    assert!(!stage.restarted());
    // Light of another kind has another history.
    stage.quell().light = QuellLight::Reflected;
    stage.frames(1);
    assert!(stage.restarted());
    // Motion reaches back by one frame, not over one that was refused.
    stage.quell().settings.budget = QuellBudget::Milliseconds(-1.0);
    stage.frames(1);
    stage.quell().settings.budget = QuellBudget::Unlimited;
    stage.frames(1);
    assert!(stage.restarted());
    // A camera that was off for a frame has no history.
    stage.camera().get_mut::<Camera>().unwrap().is_active = false;
    stage.frames(1);
    assert!(stage.view_of(stage.camera).is_none());
    stage.camera().get_mut::<Camera>().unwrap().is_active = true;
    stage.frames(1);
    assert!(stage.restarted());
}

#[test]
fn quell_is_taken_away_and_brought_back() {
    let mut stage = Stage::new((unexposed(), noisy()));
    stage.frames(8);
    let denoised = stage.picture();
    stage.camera().remove::<(Quell, Noise)>();
    stage.frames(2);
    assert!(stage.view_of(stage.camera).is_none());
    let clean = clean();
    assert!(psnr_db(&stage.picture(), &clean) > psnr_db(&denoised, &clean));
    stage.camera().insert((unexposed(), noisy()));
    stage.frames(1);
    assert!(stage.restarted());
}

#[test]
fn two_cameras_have_a_history_each() {
    let mut stage = Stage::new((unexposed(), noisy()));
    let small = [64, 40];
    let image = headless::image(&mut stage.app, small);
    let other = Stage::spawn(stage.app.world_mut(), &image, (unexposed(), noisy()));
    stage.frames(4);
    assert_eq!(stage.view().size(), Some(SIZE));
    assert_eq!(stage.view_of(other).unwrap().size(), Some(small));
    assert!(!stage.restarted());
    stage.app.world_mut().get_mut::<Quell>(other).unwrap().restart();
    stage.frames(1);
    assert!(!stage.restarted() && stage.view_of(other).unwrap().outcome().unwrap().unwrap().restarted);
    let alone = {
        let mut alone = Stage::new((unexposed(), noisy()));
        alone.frames(5);
        alone.picture()
    };
    let psnr = psnr_db(&stage.picture(), &alone);
    assert!(psnr > 35.0, "{psnr:.2} dB from one camera alone");
}

/// Two cameras that share a target: each denoises its half.
#[test]
fn split_screens_are_denoised() {
    let half = |x| Viewport {
        physical_position: UVec2::new(x, 0),
        physical_size: UVec2::new(SIZE[0] / 2, SIZE[1]),
        ..default()
    };
    let split = |is_noisy: bool| {
        let mut stage = Stage::new(unexposed());
        let image = stage.image.clone();
        let other = Stage::spawn(stage.app.world_mut(), &image, unexposed());
        for (camera, x, order) in [(stage.camera, 0, 0), (other, SIZE[0] / 2, 1)] {
            let mut camera = stage.app.world_mut().entity_mut(camera);
            let mut settings = camera.get_mut::<Camera>().unwrap();
            (settings.viewport, settings.order) = (Some(half(x)), order);
            if order == 1 {
                settings.clear_color = ClearColorConfig::None;
            }
            if is_noisy {
                camera.insert(noisy());
            } else {
                camera.remove::<Quell>();
                camera.insert(drawn());
            }
        }
        stage.frames(12);
        if is_noisy {
            assert_eq!(stage.view().size(), Some([SIZE[0] / 2, SIZE[1]]));
        }
        stage.picture()
    };
    let (clean, denoised) = (split(false), split(true));
    for x in [0, SIZE[0] / 2] {
        let half = |image: &Picture| {
            let row = |y| &image.pixels[(y * SIZE[0] + x) as usize..][..SIZE[0] as usize / 2];
            let pixels = (0..SIZE[1]).flat_map(row).copied().collect();
            Picture { width: SIZE[0] / 2, height: SIZE[1], pixels }
        };
        let psnr = psnr_db(&half(&denoised), &half(&clean));
        assert!(psnr > 25.0, "the half at {x}: {psnr:.2} dB");
    }
}

#[test]
fn a_target_may_change_its_size() {
    let mut stage = Stage::new((unexposed(), noisy()));
    stage.frames(3);
    let handle = stage.image.clone();
    let size = Extent3d { width: 96, height: 54, depth_or_array_layers: 1 };
    stage.app.world_mut().resource_mut::<Assets<Image>>().get_mut(&handle).unwrap().resize(size);
    stage.frames(3);
    assert_eq!(stage.refusal(), None);
    assert_eq!(stage.view().size(), Some([96, 54]));
    assert_eq!(stage.picture().width, 96);
}

/// History goes on while the resolution changes.
#[test]
fn resolution_may_be_dynamic() {
    let mut stage = Stage::new((unexposed(), noisy()));
    stage.frames(3);
    for width in [96, 80, 112] {
        let entity = stage.render_entity(stage.camera).unwrap();
        let size = UVec2::new(width, width * 9 / 16);
        let render_world = stage.app.sub_app_mut(RenderApp).world_mut();
        render_world.entity_mut(entity).insert(MainPassResolutionOverride(size));
        stage.frames(1);
        assert_eq!(stage.refusal(), None);
        assert!(!stage.restarted());
        assert_eq!(stage.view().size(), Some(SIZE));
    }
}

/// An app with the plugin and no camera that has quell draws what one without draws.
#[test]
fn the_plugin_alone_changes_nothing() {
    let bare = Stage::begin(headless::app(), ());
    let mut app = headless::app();
    app.add_plugins(QuellPlugin);
    let stage = Stage::begin(app, ());
    assert!(stage.view_of(stage.camera).is_none());
    let psnr = psnr_db(&stage.picture(), &bare.picture());
    assert!(psnr > 60.0, "{psnr:.2} dB");
}

#[test]
fn timings_are_among_bevys_diagnostics() {
    let mut stage = Stage::new((unexposed(), noisy()));
    stage.frames(12);
    let store = stage.app.world().resource::<DiagnosticsStore>();
    let paths: Vec<_> = store.iter().map(|diagnostic| diagnostic.path().as_str().to_owned()).collect();
    for pass in ["quell", "quell/reproject", "quell/fit", "quell/compose"] {
        let path = DiagnosticPath::new(format!("render/{pass}/elapsed_cpu"));
        assert!(store.get(&path).is_some(), "no {path} in {paths:#?}");
    }
    assert!(!paths.iter().any(|path| path.contains("specular")), "{paths:#?}");
}

#[test]
fn an_image_of_ones_own_is_denoised_into_another() {
    let mut stage = Stage::new(drawn());
    let denoised = headless::image(&mut stage.app, SIZE);
    // What the camera draws is the radiance; not loaded at first.
    let mut images = QuellImages { radiance: default(), denoised: denoised.clone(), ..default() };
    images.radiance = stage.app.world().resource::<Assets<Image>>().reserve_handle();
    stage.camera().insert(Quell { signal: QuellSignal::Images(images.clone()), ..unexposed() });
    stage.frames(2);
    assert_eq!(stage.refusal(), Some(Refusal::Image("radiance")));
    images.radiance = stage.image.clone();
    stage.quell().signal = QuellSignal::Images(images);
    stage.frames(6);
    assert_eq!(stage.refusal(), None);
    let denoised = headless::read(&stage.app, &denoised).unwrap();
    let psnr = psnr_db(&denoised, &stage.picture());
    assert!(psnr > 40.0, "{psnr:.2} dB");
}

#[test]
fn settings_reach_quell_and_wrong_ones_are_named() {
    assert_eq!(Settings::from(QuellSettings::default()), Settings::default());
    for preset in [Settings::responsive(), Settings::still(), Settings::fast()] {
        assert_eq!(Settings::from(QuellSettings::from(preset)), preset);
    }
    let mut stage = Stage::new(unexposed());
    stage.quell().settings.budget = QuellBudget::Milliseconds(-1.0);
    stage.frames(2);
    let message = stage.refusal().unwrap().to_string();
    assert!(message.contains("budget"), "{message}");
}

#[test]
fn a_debug_view_takes_the_images_place() {
    let mut stage = Stage::new((unexposed(), noisy()));
    stage.frames(4);
    let denoised = stage.picture();
    stage.quell().debug = Some(DebugView::Normal);
    stage.frames(1);
    let debug = stage.picture();
    assert_eq!(stage.refusal(), None);
    assert!(psnr_db(&debug, &denoised) < 25.0);
    stage.quell().debug = None;
    stage.frames(1);
    let psnr = psnr_db(&stage.picture(), &denoised);
    assert!(psnr > 30.0, "{psnr:.2} dB");
}

#[test]
fn the_component_is_reflected() {
    let app = {
        let mut app = headless::app();
        app.add_plugins(QuellPlugin);
        app
    };
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let registration = registry.get(std::any::TypeId::of::<Quell>()).expect("`Quell` is registered");
    assert!(
        registration.data::<ReflectComponent>().is_some() && registration.data::<ReflectDefault>().is_some()
    );
}
