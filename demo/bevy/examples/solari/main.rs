//! Walks through a scene lit by Solari, with quell, and measures both against Solari's path tracer. Needs no window.
//!
//! `cargo run --ignore-rust-version --example solari [-- --scene room --out DIR --frames N --size WxH --reference SPP]`
//!
//! Where the GPU has no ray queries, or with `--effect`, the scene is lit by a noisy screen-space skylight instead, written to a texture of
//! the example's own: see `skylight.rs`.

mod headless;
mod picture;
mod scenes;
mod skylight;

use bevy::camera::{CameraMainTextureUsages, RenderTarget};
use bevy::core_pipeline::core_3d::main_opaque_pass_3d;
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::core_pipeline::schedule::Core3d;
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::extract_component::{ExtractComponent, ExtractComponentPlugin};
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::TextureUsages;
use bevy::render::renderer::{RenderContext, RenderDevice, ViewQuery};
use bevy::render::texture::GpuImage;
use bevy::render::view::ViewTarget;
use bevy::solari::pathtracer::{Pathtracer, PathtracingPlugin};
use bevy::solari::prelude::{SolariLighting, SolariPlugins};
use clap::{Parser, ValueEnum};
use picture::{Picture, psnr_db, temporal_psnr_db};
use quell_bevy::{Quell, QuellImages, QuellLight, QuellPlugin, QuellSignal, QuellSystems};
use scenes::{Cart, Scene, size};
use skylight::{Skylight, SkylightPlugin};
use std::path::{Path, PathBuf};

/// llvmpipe leaves loops after 65535 rounds, of which a sample takes 25.
const SKYLIGHT_SAMPLES: u32 = 1024;

#[derive(Parser)]
struct Args {
    /// What is walked through.
    #[arg(long, value_enum, default_value = "room")]
    scene: Scene,
    /// Folder that receives the pictures.
    #[arg(long, default_value = "out/bevy")]
    out: PathBuf,
    /// Frames of the walk that are measured, at 60 a second.
    #[arg(long, default_value = "8", value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,
    /// Frames that are walked before.
    #[arg(long, default_value = "24")]
    warm_up: u32,
    #[arg(long, default_value = "256x144", value_parser = size)]
    size: [u32; 2],
    /// Samples per pixel of each frame's reference; of the skylight it has 1024.
    #[arg(long, default_value = "256", value_parser = clap::value_parser!(u32).range(1..))]
    reference: u32,
    /// Have quell say in the log which of its inputs look wrong.
    #[arg(long)]
    check: bool,
    /// Light the scene by the noisy screen-space skylight, also where Solari runs.
    #[arg(long)]
    effect: bool,
}

fn main() -> Result<()> {
    let args = Args::parse();
    let scene = args.scene.to_possible_value().expect("none is hidden");
    let out = args.out.join(scene.get_name());
    std::fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;

    let mut app = headless::app();
    app.add_plugins((SolariPlugins, PathtracingPlugin, QuellPlugin, SkylightPlugin, CopyPlugin));
    headless::begin(&mut app);
    let device = app.sub_app(RenderApp).world().resource::<RenderDevice>();
    let missing = SolariPlugins::required_wgpu_features().difference(device.features());
    if !missing.is_empty() {
        let names: Vec<_> = missing.iter_names().map(|(name, _)| name).collect();
        println!("no Solari: this GPU has no {}. A noisy skylight stands in.", names.join(", "));
    }
    let studio = Studio::new(&mut app, &args, !args.effect && missing.is_empty());

    let walk = studio.walk(&mut app, &args)?;
    let references = studio.references(&mut app, &args)?;
    report(&walk, &references, &out)
}

/// The scene, its cameras and their images.
struct Studio {
    scene: Scene,
    /// Walks, with quell.
    walker: Entity,
    /// Sees the same for the reference.
    tracer: Entity,
    noisy: Handle<Image>,
    denoised: Handle<Image>,
    reference: Handle<Image>,
    /// Updates that a reference takes.
    updates: u32,
}

/// What one frame of the walk came to.
struct Frame {
    noisy: Picture,
    denoised: Picture,
}

impl Studio {
    fn new(app: &mut App, args: &Args, has_solari: bool) -> Self {
        let [noisy, denoised, reference, unused] = [(); 4].map(|()| headless::image(app, args.size));
        let scene = args.scene;
        let world = app.world_mut();
        world.insert_resource(ClearColor(Color::BLACK));
        scene.spawn(world);
        // Draws linear light as it comes.
        let camera = |target: &Handle<Image>| {
            let target = RenderTarget::from(target.clone());
            (
                Camera3d::default(),
                target,
                scene.exposure(),
                Tonemapping::None,
                DebandDither::Disabled,
                Msaa::Off,
            )
        };
        let (walker, tracer, updates);
        if has_solari {
            let storage = CameraMainTextureUsages::default().with(TextureUsages::STORAGE_BINDING);
            let quell = Quell { check_inputs: args.check, ..default() };
            let solari = (SolariLighting::default(), quell);
            walker = world.spawn((camera(&denoised), storage, solari, CopyNoisy(noisy.clone()))).id();
            tracer = world.spawn((camera(&reference), storage, Pathtracer::default())).id();
            updates = args.reference;
        } else {
            let images = QuellImages { radiance: noisy.clone(), denoised: denoised.clone(), ..default() };
            let quell = Quell {
                signal: QuellSignal::Images(images),
                light: QuellLight::Incident,
                check_inputs: args.check,
                ..default()
            };
            walker =
                world.spawn((camera(&unused), Skylight { image: noisy.clone(), samples: 1 }, quell)).id();
            let converged = Skylight { image: reference.clone(), samples: SKYLIGHT_SAMPLES };
            let prepasses = (DepthPrepass, DeferredPrepass);
            tracer = world.spawn((camera(&unused), converged, prepasses)).id();
            updates = 1;
        }
        Self { scene, walker, tracer, noisy, denoised, reference, updates }
    }

    fn walk(&self, app: &mut App, args: &Args) -> Result<Vec<Frame>> {
        self.turn_on(app, self.walker);
        for i in 0..args.warm_up {
            self.set_time(app, i as f32 - args.warm_up as f32);
            headless::update(app)?;
        }
        (0..args.frames)
            .map(|i| {
                self.set_time(app, i as f32);
                headless::update(app)?;
                eprintln!("frame {} of {}", i + 1, args.frames);
                Ok(Frame {
                    noisy: headless::read(app, &self.noisy)?,
                    denoised: headless::read(app, &self.denoised)?,
                })
            })
            .collect()
    }

    fn references(&self, app: &mut App, args: &Args) -> Result<Vec<Picture>> {
        self.turn_on(app, self.tracer);
        (0..args.frames)
            .map(|i| {
                self.set_time(app, i as f32);
                for _ in 0..self.updates {
                    headless::update(app)?;
                }
                eprintln!("reference {} of {}", i + 1, args.frames);
                headless::read(app, &self.reference)
            })
            .collect()
    }

    fn turn_on(&self, app: &mut App, camera: Entity) {
        for other in [self.walker, self.tracer] {
            let mut entity = app.world_mut().entity_mut(other);
            entity.get_mut::<Camera>().expect("was spawned with one").is_active = other == camera;
        }
    }

    /// Moves what moves to where it is in a frame of the walk.
    fn set_time(&self, app: &mut App, frame: f32) {
        let world = app.world_mut();
        for camera in [self.walker, self.tracer] {
            *world.entity_mut(camera).get_mut::<Transform>().expect("cameras have one") =
                self.scene.camera(frame);
        }
        for mut cart in world.query_filtered::<&mut Transform, With<Cart>>().iter_mut(world) {
            *cart = self.scene.cart(frame);
        }
    }
}

/// Writes the pictures, and prints what they are apart from the reference.
fn report(walk: &[Frame], references: &[Picture], out: &Path) -> Result<()> {
    for (i, (frame, reference)) in walk.iter().zip(references).enumerate() {
        let sheet = Picture::beside(&[&frame.noisy, &frame.denoised, reference]);
        sheet.save(&out.join(format!("frame_{i:03}.png")))?;
    }
    let (noisy, denoised): (Vec<_>, Vec<_>) =
        walk.iter().map(|frame| (&frame.noisy, &frame.denoised)).unzip();
    for (name, pictures) in [("noisy", noisy), ("denoised", denoised)] {
        let psnr = pictures.iter().zip(references).map(|(picture, reference)| psnr_db(picture, reference));
        let temporal = pictures.windows(2).zip(references.windows(2)).map(|(pictures, references)| {
            temporal_psnr_db([pictures[0], pictures[1]], [&references[0], &references[1]])
        });
        let (psnr, temporal) = (mean(psnr)?, mean(temporal)?);
        println!("{name}: {psnr:.2} dB PSNR, {temporal:.2} dB temporal PSNR");
    }
    println!("pictures (noisy, denoised, reference) are in {}", out.display());
    Ok(())
}

fn mean(values: impl Iterator<Item = Result<f64>>) -> Result<f64> {
    let values: Vec<f64> = values.collect::<Result<_>>()?;
    Ok(values.iter().sum::<f64>() / values.len() as f64)
}

/// Copies the camera's view target, before quell denoises it, to an image.
#[derive(Component, ExtractComponent, Clone)]
#[extract_app(RenderApp)]
struct CopyNoisy(Handle<Image>);

struct CopyPlugin;

impl Plugin for CopyPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(ExtractComponentPlugin::<CopyNoisy>::default());
        app.sub_app_mut(RenderApp)
            .add_systems(Core3d, copy_noisy.after(main_opaque_pass_3d).before(QuellSystems::Denoise));
    }
}

fn copy_noisy(
    view: ViewQuery<(&CopyNoisy, &ViewTarget)>,
    images: Res<RenderAssets<GpuImage>>,
    mut ctx: RenderContext,
) {
    let (CopyNoisy(image), target) = view.into_inner();
    let Some(image) = images.get(image) else { return };
    let size = image.texture.size();
    let [from, to] = [target.main_texture(), &image.texture].map(|texture| texture.as_image_copy());
    ctx.command_encoder().copy_texture_to_texture(from, to, size);
}
