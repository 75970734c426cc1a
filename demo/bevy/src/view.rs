//! What the render world holds for quell: shared pipelines, and per view a denoiser and its images.

use crate::decode::{Decoded, Decoder, image};
use crate::show::Show;
use crate::{Quell, QuellLight, QuellSignal, Refusal};
use bevy::ecs::{component::Component, entity::Entity, resource::Resource};
use bevy::log::{error, info, warn};
use quell::wgpu::{Device, TextureFormat, TextureView};
use quell::{
    CreateError, Denoiser, DenoiserDescriptor, Finding, FrameOutputs, InputCheck, Notice, Pipelines, Untold,
};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Compiled passes, from the first view that needs them on. Made anew where bevy recovers from a lost device.
#[derive(Resource, Default)]
pub struct Shared(Mutex<Option<Arc<Compiled>>>);

pub struct Compiled {
    pub pipelines: Arc<Pipelines>,
    pub decoder: Decoder,
    pub show: Show,
}

/// A view's denoiser, on the camera's entity in the render world.
#[derive(Component, Default)]
pub struct QuellView(Mutex<ViewState>);

#[derive(Default)]
pub struct ViewState {
    resources: Option<ViewResources>,
    /// The newest frame that was denoised.
    pub last: Option<FrameId>,
    outcome: Option<Result<FrameOutputs, Refusal>>,
    draws_forward_only: bool,
    /// Of [`InputCheck`]'s, how many were said.
    findings: usize,
}

/// What tells whether one frame's history is of use to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameId {
    /// Bevy's count.
    frame: u32,
    restarts: u32,
    is_view: bool,
    light: QuellLight,
}

impl FrameId {
    pub fn new(frame: u32, quell: &Quell) -> Self {
        let is_view = quell.signal == QuellSignal::View;
        Self { frame, restarts: quell.restarts, is_view, light: quell.light }
    }

    /// Whether this is the frame after `last` of the same thing. Where one was left out, motion vectors do not reach back far enough.
    pub fn continues(&self, last: &Self) -> bool {
        *self == Self { frame: last.frame.wrapping_add(1), ..*last }
    }
}

/// All that lives on the GPU, for one size of view and of target.
pub struct ViewResources {
    pub compiled: Arc<Compiled>,
    pub denoiser: Denoiser,
    pub decoded: Decoded,
    pub check: Option<InputCheck>,
    /// What will be drawn to the view target, where that is what is denoised.
    pub shown: Option<TextureView>,
    /// The denoised image, where a debug view is shown instead of it.
    pub hidden: Option<TextureView>,
}

impl Shared {
    pub fn compiled(&self, device: &Device) -> Result<Arc<Compiled>, CreateError> {
        let mut compiled = lock(&self.0);
        if compiled.is_none() {
            let pipelines = Arc::new(Pipelines::new(device)?);
            *compiled = Some(Arc::new(Compiled {
                pipelines,
                decoder: Decoder::new(device),
                show: Show::new(device),
            }));
        }
        Ok(compiled.clone().expect("was made above"))
    }
}

impl QuellView {
    /// What became of this view's newest frame; none before the first.
    pub fn outcome(&self) -> Option<Result<FrameOutputs, Refusal>> {
        lock(&self.0).outcome.clone()
    }

    /// Whether all that the newest frame shows was drawn forward, so that nothing of it was denoised.
    pub fn draws_forward_only(&self) -> bool {
        lock(&self.0).draws_forward_only
    }

    /// What [`Quell::check_inputs`] has found; empty where it is off.
    pub fn findings(&self) -> Vec<Finding> {
        lock(&self.0).findings()
    }

    /// What [`Quell::check_inputs`] cannot tell from what it has seen; empty where it is off.
    pub fn untold(&self) -> Vec<Untold> {
        lock(&self.0).check().map(|check| check.untold()).unwrap_or_default()
    }

    /// Size of the denoiser in pixels; none before the first denoised frame.
    pub fn size(&self) -> Option<[u32; 2]> {
        Some(lock(&self.0).resources.as_ref()?.denoiser.size())
    }

    pub(crate) fn state(&self) -> MutexGuard<'_, ViewState> {
        lock(&self.0)
    }
}

impl ViewResources {
    /// Makes what a frame of [`Quell`] takes besides the denoiser, and frees what it no longer does.
    pub fn serve(&mut self, device: &Device, quell: &Quell) -> Result<(), CreateError> {
        if !quell.check_inputs {
            self.check = None;
        } else if self.check.is_none() {
            let [width, height] = self.denoiser.size();
            self.check = Some(InputCheck::new(device, &DenoiserDescriptor::new(width, height))?);
        }
        let size = self.decoded.size();
        let image = |label| image(device, label, size, TextureFormat::Rgba16Float);
        keep(&mut self.shown, quell.signal == QuellSignal::View, || image("quell bevy shown"));
        keep(&mut self.hidden, quell.debug.is_some(), || image("quell bevy hidden"));
        Ok(())
    }
}

impl ViewState {
    /// What a view of `size` on a target of `target_size` pixels needs; history is kept where neither changed.
    pub fn resources(
        &mut self,
        device: &Device,
        compiled: Arc<Compiled>,
        [size, target_size]: [[u32; 2]; 2],
    ) -> Result<&mut ViewResources, CreateError> {
        let [width, height] = size;
        let descriptor = DenoiserDescriptor::new(width, height);
        if self.resources.as_ref().is_none_or(|r| !Arc::ptr_eq(&r.compiled, &compiled)) {
            let pipelines = Arc::clone(&compiled.pipelines);
            let denoiser = Denoiser::with_pipelines(device, &descriptor, pipelines)?;
            let decoded = Decoded::new(device, target_size);
            self.resources =
                Some(ViewResources { compiled, denoiser, decoded, check: None, shown: None, hidden: None });
        }
        let resources = self.resources.as_mut().expect("was made above");
        if resources.denoiser.size() != size {
            resources.denoiser.resize(device, &descriptor)?;
            resources.check = None;
        }
        if resources.decoded.size() != target_size {
            resources.decoded = Decoded::new(device, target_size);
            (resources.shown, resources.hidden) = (None, None);
        }
        Ok(resources)
    }

    /// Says once what became of a view's frames, and again when that changes.
    pub fn report(&mut self, entity: Entity, outcome: Result<FrameOutputs, Refusal>, is_forward: bool) {
        let was_refused = matches!(self.outcome, Some(Err(_)));
        match &outcome {
            Err(refusal) if self.outcome.as_ref() != Some(&outcome) => {
                error!("quell does not denoise camera {entity}: {refusal}.");
            }
            Ok(_) if was_refused => info!("quell denoises camera {entity} again."),
            Ok(FrameOutputs { notice: Some(Notice::NoTimestamps), .. }) => {
                warn!(
                    "quell, camera {entity}: a budget of time, but this GPU tells no times; it has no effect."
                );
            }
            _ => {}
        }
        self.outcome = Some(outcome);
        if is_forward && !self.draws_forward_only {
            warn!(
                "quell, camera {entity}: all that it sees is drawn forward and passes through as it is; insert \
                 `DefaultOpaqueRendererMethod::deferred()`, or give materials `OpaqueRendererMethod::Deferred`."
            );
        }
        self.draws_forward_only = is_forward;
        let findings = self.findings();
        for finding in findings.iter().skip(self.findings) {
            warn!("quell, inputs of camera {entity}: {finding}");
        }
        self.findings = findings.len();
    }

    fn check(&mut self) -> Option<&mut InputCheck> {
        self.resources.as_mut()?.check.as_mut()
    }

    fn findings(&mut self) -> Vec<Finding> {
        self.check().map(InputCheck::findings).unwrap_or_default()
    }
}

/// Makes a thing when it is wanted and not there, drops it when it is not.
fn keep<T>(thing: &mut Option<T>, is_wanted: bool, make: impl FnOnce() -> T) {
    *thing = if is_wanted { Some(thing.take().unwrap_or_else(make)) } else { None };
}

/// A panic while the lock was held leaves a denoiser that is whole: `encode` changes it last.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
