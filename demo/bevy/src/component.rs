//! What a user adds to a camera.

use bevy::asset::Handle;
use bevy::camera::Hdr;
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass};
use bevy::ecs::{
    component::Component, lifecycle::HookContext, reflect::ReflectComponent, world::DeferredWorld,
};
use bevy::image::Image;
use bevy::reflect::{Reflect, std_traits::ReflectDefault};
use bevy::render::view::Msaa;
use quell::{Budget, DebugView, Settings};

/// Denoises what this 3D camera sees. Removing the component, or deactivating the camera, stops it and frees what it held.
///
/// Brings the prepasses that it reads with it and `Hdr`, and sets `Msaa::Off`: ray-traced frames have one sample a pixel.
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default, Clone)]
#[require(Hdr, DeferredPrepass, DepthPrepass, MotionVectorPrepass)]
#[component(on_add = set_msaa_off)]
pub struct Quell {
    /// How it denoises. The default is meant to be left alone.
    pub settings: QuellSettings,
    /// What is denoised.
    pub signal: QuellSignal,
    /// What light the signal holds.
    pub light: QuellLight,
    /// Shows what one step of the denoiser sees instead of the denoised image: whether motion and history are right is seen best in
    /// `DebugView::Motion` and `DebugView::HistoryLength`.
    #[reflect(ignore)]
    pub debug: Option<DebugView>,
    /// Says in the log which input looks wrong. A tool for who writes a signal of their own; costs time and 32 bytes a pixel.
    pub check_inputs: bool,
    /// History is dropped in a frame in which this number has changed: see [`Quell::restart`].
    pub restarts: u32,
}

/// Bevy would, too, but with a warning: cameras have multisampling by default, and deferred ones cannot.
fn set_msaa_off(mut world: DeferredWorld, context: HookContext) {
    world.commands().entity(context.entity).insert(Msaa::Off);
}

impl Quell {
    /// Drops history, in the next frame alone: after a cut or a teleport, whose motion vectors mean nothing, and where an image of
    /// [`QuellImages`] holds other light than before. Solari and TAA have histories of their own: set their `reset` too.
    pub fn restart(&mut self) {
        self.restarts = self.restarts.wrapping_add(1);
    }
}

/// What is denoised.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone)]
pub enum QuellSignal {
    /// The camera's view target as the opaque pass left it; denoised in place. What Solari writes, and any effect that draws over
    /// the view target before [`QuellSystems::Denoise`](crate::QuellSystems).
    #[default]
    View,
    /// Images of your own.
    Images(QuellImages),
}

/// Images of the camera's target's size, which may be others in each frame, written before [`QuellSystems::Denoise`](crate::QuellSystems) in the same frame.
/// Formats are those of [`FrameInputs`](quell::FrameInputs)' fields of the same names; all need `TextureUsages::TEXTURE_BINDING`, and `denoised`
/// `STORAGE_BINDING` too.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone)]
pub struct QuellImages {
    /// Noisy linear light, `Rgba16Float` for example.
    pub radiance: Handle<Image>,
    /// Receives the denoised light. `Rgba16Float`.
    pub denoised: Handle<Image>,
    /// The part of the light that left the first hit through the specular lobe; `radiance` then holds the rest.
    pub specular: Option<Handle<Image>>,
    /// Distance from the first hit to what its specular ray hit.
    pub hit_distance: Option<Handle<Image>>,
    /// Identity of object and material.
    pub surface_id: Option<Handle<Image>>,
    /// Samples traced at each pixel in this frame.
    pub sample_count: Option<Handle<Image>>,
}

/// What light a signal holds, so that what has no noise can be taken out before filtering and put back after.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Default, Clone)]
pub enum QuellLight {
    /// All that the camera sees, with emission times the camera's exposure. What Solari writes.
    #[default]
    Exposed,
    /// All that the camera sees, with emission that is not exposed. What bevy's own deferred lighting writes, so right for noisy
    /// light that was added to it.
    Unexposed,
    /// Light that surfaces reflect, without what they emit.
    Reflected,
    /// Light that arrives: not multiplied by the base colour, without emission. Ambient occlusion, shadow masks, irradiance.
    Incident,
}

impl QuellLight {
    /// What the light holds of what surfaces emit.
    pub(crate) fn emission_scale(self, exposure: f32) -> f32 {
        match self {
            Self::Exposed => exposure,
            Self::Unexposed => 1.0,
            Self::Reflected | Self::Incident => 0.0,
        }
    }
}

/// The settings of [`quell::Settings`] that games touch, as bevy reflects them. `QuellSettings::from` takes its presets:
/// `quell::Settings::responsive().into()`.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct QuellSettings {
    /// How long history is, in frames of one sample per pixel; 1 to 1024, default 32. Higher keeps more detail and less noise; lower
    /// follows changes of the light sooner.
    pub max_history: f32,
    /// Whether the change of the light is predicted and history relit by it (default true). Off, a light that was switched fades.
    pub innovation: bool,
    /// By how many standard errors of its neighbourhood's mean a single sample may move that mean, above 0 (default 1); infinity
    /// cuts no fireflies.
    pub firefly_limit: f32,
    /// Whether the output mixes the models' prediction with the temporal mean by estimated error (default true).
    pub mix_temporal_mean: bool,
    /// What a frame may cost (default: as much as the image needs).
    pub budget: QuellBudget,
}

/// See [`quell::Budget`].
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub enum QuellBudget {
    /// As many models as the image needs.
    #[default]
    Unlimited,
    /// At most so many models.
    Models(u32),
    /// As many models as keep the denoiser's time on the GPU below so many milliseconds, above 0.
    Milliseconds(f32),
}

impl Default for QuellSettings {
    fn default() -> Self {
        Settings::default().into()
    }
}

impl From<Settings> for QuellSettings {
    fn from(settings: Settings) -> Self {
        Self {
            max_history: settings.max_history,
            innovation: settings.innovation,
            firefly_limit: settings.firefly_limit,
            mix_temporal_mean: settings.mix_temporal_mean,
            budget: match settings.budget {
                Budget::Models(models) => QuellBudget::Models(models),
                Budget::Milliseconds(target) => QuellBudget::Milliseconds(target),
                _ => QuellBudget::Unlimited,
            },
        }
    }
}

impl From<QuellSettings> for Settings {
    fn from(settings: QuellSettings) -> Self {
        Self::default()
            .with_max_history(settings.max_history)
            .with_innovation(settings.innovation)
            .with_firefly_limit(settings.firefly_limit)
            .with_mix_temporal_mean(settings.mix_temporal_mean)
            .with_budget(match settings.budget {
                QuellBudget::Unlimited => Budget::Unlimited,
                QuellBudget::Models(models) => Budget::Models(models),
                QuellBudget::Milliseconds(target) => Budget::Milliseconds(target),
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn emission_is_scaled_by_what_the_light_is() {
        let lights =
            [QuellLight::Exposed, QuellLight::Unexposed, QuellLight::Reflected, QuellLight::Incident];
        assert_eq!(lights.map(|light| light.emission_scale(0.25)), [0.25, 1.0, 0.0, 0.0]);
    }
}
