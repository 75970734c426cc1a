//! A window on a scene lit by Solari, with and without quell: `T` turns it off and on, `1`, `2` and `3` show its motion, history and
//! normals, `R` drops history; W, A, S, D, Q, E and the mouse move.
//!
//! `cargo run --ignore-rust-version --features window --example window [-- room]`

#[path = "solari/scenes.rs"]
mod scenes;

use bevy::camera::CameraMainTextureUsages;
use bevy::camera_controller::free_camera::{FreeCamera, FreeCameraPlugin};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::render_resource::TextureUsages;
use bevy::solari::prelude::{SolariLighting, SolariPlugins};
use clap::Parser;
use quell_bevy::quell::DebugView;
use quell_bevy::{Quell, QuellPlugin};
use scenes::{Cart, Scene, size};

#[derive(Parser, Resource, Clone, Copy)]
struct Args {
    /// What is walked through.
    #[arg(value_enum, default_value = "court")]
    scene: Scene,
    #[arg(long, default_value = "1280x720", value_parser = size)]
    size: [u32; 2],
    /// Leave after so many frames.
    #[arg(long)]
    frames: Option<u32>,
}

fn main() {
    let args = Args::parse();
    let [width, height] = args.size;
    let window = Window { resolution: (width, height).into(), title: "quell".into(), ..default() };
    let window = WindowPlugin { primary_window: Some(window), ..default() };
    App::new()
        .insert_resource(args)
        .insert_resource(ClearColor(Color::BLACK))
        .add_plugins((DefaultPlugins.set(window), FreeCameraPlugin, SolariPlugins, QuellPlugin))
        .add_systems(Startup, (spawn_scene, spawn_camera))
        .add_systems(Update, (drive_cart, keys, leave))
        .run();
}

fn spawn_scene(world: &mut World) {
    let Args { scene, .. } = *world.resource();
    scene.spawn(world);
}

fn spawn_camera(mut commands: Commands, args: Res<Args>) {
    let storage = CameraMainTextureUsages::default().with(TextureUsages::STORAGE_BINDING);
    let free = (args.scene.camera(0.0), FreeCamera { walk_speed: 2.0, ..default() });
    // Bevy's default tonemapping needs another of its features.
    let camera = (Camera3d::default(), args.scene.exposure(), Tonemapping::AcesFitted, free);
    // Solari draws to a storage texture.
    commands.spawn((camera, SolariLighting::default(), storage, Quell::default()));
}

fn drive_cart(time: Res<Time>, args: Res<Args>, mut carts: Query<&mut Transform, With<Cart>>) {
    for mut cart in &mut carts {
        *cart = args.scene.cart(60.0 * (time.elapsed_secs() % 3.0));
    }
}

fn keys(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    mut camera: Single<(Entity, Option<&mut Quell>), With<Camera3d>>,
) {
    let (entity, quell) = &mut *camera;
    let Some(quell) = quell else {
        if keys.just_pressed(KeyCode::KeyT) {
            commands.entity(*entity).insert(Quell::default());
        }
        return;
    };
    for (key, view) in [
        (KeyCode::Digit1, DebugView::Motion),
        (KeyCode::Digit2, DebugView::HistoryLength),
        (KeyCode::Digit3, DebugView::Normal),
    ] {
        if keys.just_pressed(key) {
            quell.debug = (quell.debug != Some(view)).then_some(view);
        }
    }
    if keys.just_pressed(KeyCode::KeyR) {
        quell.restart();
    }
    if keys.just_pressed(KeyCode::KeyT) {
        commands.entity(*entity).remove::<Quell>();
    }
}

fn leave(args: Res<Args>, mut frame: Local<u32>, mut exit: MessageWriter<AppExit>) {
    *frame += 1;
    if Some(*frame) == args.frames {
        exit.write(AppExit::Success);
    }
}
