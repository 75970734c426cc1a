//! quell for bevy: denoises Solari's ray-traced lighting, and any other noisy light, on any GPU. Add [`QuellPlugin`] to the app and
//! [`Quell`] to a camera; the README has an example, and what else there is to know.
//!
//! # A frame
//!
//! 1. `extract` copies each active camera's [`Quell`] to the render world, and takes it away again.
//! 2. `denoise`, one system of the `Core3d` schedule, runs once per camera, after the opaque pass and before transmissive and
//!    transparent things, so before TAA, upscalers and bloom. It decodes the deferred G-buffer (`decode.wgsl`) and calls
//!    [`quell::Denoiser::encode`], whose output is drawn over the view target (`show.wgsl`).
//!
//! Skies, and what is drawn forward (unlike `StandardMaterial`s, custom materials are by default), have no noise and pass through.
//!
//! # What it needs
//!
//! - Prepasses of depth and motion and the deferred one, HDR, no MSAA: [`Quell`] brings them along. Where one is missing all the same, an
//!   error in the log names it and the frame stays noisy.
//! - Materials in the deferred G-buffer. Solari sees to that; without it, insert `DefaultOpaqueRendererMethod::deferred()`, and
//!   give all other cameras a deferred prepass too, or they draw nothing. Where a camera draws forward only, a warning says so.
//! - Motion vectors that are true. What moves without them ghosts.
//! - A camera without scale, in its own transform and its parents'.
//!
//! # What else there is
//!
//! - **Cuts and teleports**: [`Quell::restart`]. History is also dropped where a camera's frame was left out.
//! - **Sizes**: windows that are resized, viewports of split screens, and `MainPassResolutionOverride`, which may change in every frame.
//! - **Several cameras**: each has a history of its own; compiled passes are shared.
//! - **Timings**: with bevy's `RenderDiagnosticsPlugin`, `render/quell` and one per pass, `render/quell/fit` for example.
//! - **Anti-aliasing**: `TemporalAntiAliasing` beside [`Quell`]. quell keeps history without jitter and takes none away.

#![warn(missing_docs)]

mod component;
mod conventions;
mod decode;
mod denoise;
mod extract;
mod refusal;
mod show;
mod timings;
mod view;

pub use component::{Quell, QuellBudget, QuellImages, QuellLight, QuellSettings, QuellSignal};
pub use quell;
pub use refusal::Refusal;
pub use view::QuellView;

use bevy::app::{App, Plugin, PostUpdate};
use bevy::camera::Camera3d;
use bevy::core_pipeline::{
    core_3d::{main_opaque_pass_3d, main_transparent_pass_3d},
    schedule::{Core3d, Core3dSystems},
};
use bevy::ecs::entity::Entity;
use bevy::ecs::query::{Added, Without};
use bevy::ecs::schedule::{IntoScheduleConfigs, SystemSet};
use bevy::ecs::system::Query;
use bevy::log::warn;
use bevy::pbr::main_transmissive_pass_3d;
use bevy::render::{ExtractSchedule, GpuResourceAppExt, RenderApp};

fn warn_where_there_is_no_camera(lost: Query<Entity, (Added<Quell>, Without<Camera3d>)>) {
    for entity in &lost {
        warn!("{entity} has `Quell` but no `Camera3d`; quell does nothing there.");
    }
}

/// Compiles the README's examples.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// Lets cameras have [`Quell`]. Changes and costs nothing while none has.
#[derive(Debug, Clone, Copy, Default)]
pub struct QuellPlugin;

/// Where quell runs in `Core3d`. Noisy light of your own goes before it, after or in the opaque pass.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum QuellSystems {
    /// Denoises the camera's signal.
    Denoise,
}

impl Plugin for QuellPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Quell>().add_systems(PostUpdate, warn_where_there_is_no_camera);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            warn!("QuellPlugin does nothing: there is no RenderApp. Add it after RenderPlugin.");
            return;
        };
        let denoise = denoise::denoise.in_set(QuellSystems::Denoise).in_set(Core3dSystems::MainPass);
        render_app
            .init_gpu_resource::<view::Shared>()
            .add_systems(ExtractSchedule, extract::extract)
            .add_systems(
                Core3d,
                denoise
                    .after(main_opaque_pass_3d)
                    .before(main_transmissive_pass_3d)
                    .before(main_transparent_pass_3d),
            );
    }
}
