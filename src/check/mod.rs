//! Tells from statistics over some frames what looks wrong with the inputs.

mod cameras;
mod evidence;
mod finding;
mod judge;
pub mod suspicion;

pub use evidence::Evidence;
pub use finding::{Finding, Mistake, Untold};

use crate::gpu::{
    FrameUniforms, Recorder, ViewUniforms, catch, check_alive, flags, image, uniform_buffer, words,
};
use crate::passes::check::{Check, CheckViews, SuspectUniforms};
use crate::readback::Readback;
use crate::{
    Camera, CreateError, DenoiserDescriptor, FrameError, FrameInputs, HistoryMode, Settings, Viewport, layout,
};
use bytemuck::Zeroable;
use cameras::Cameras;
use glam::{Mat3, Mat4, Vec3};
use judge::Given;
use wgpu::{TextureFormat, TextureView};

/// Says in words what looks wrong with the inputs of frames, and which input to look at: motion of the wrong sign or unit,
/// normals in view space, depth that is not linear, and so on (all of them: [`Mistake`]).
///
/// A tool for whoever integrates the denoiser, to be run on some tens of frames, of which some should have a moving camera:
/// what cannot be told from what was seen is not guessed ([`untold`](Self::untold)). It reads the very inputs that
/// [`Denoiser::encode`](crate::Denoiser::encode) gets and keeps no more than surfaces and motion of two frames. Like the
/// denoiser it never submits, blocks or maps within a call.
///
/// Where it speaks, it has seen that the inputs as given contradict each other, and that one other reading of one of them
/// makes them agree.
///
/// ```no_run
/// # fn check(device: &wgpu::Device, queue: &wgpu::Queue, frames: &[quell::FrameInputs])
/// # -> Result<(), Box<dyn std::error::Error>> {
/// use quell::{DenoiserDescriptor, InputCheck, Settings};
///
/// let mut check = InputCheck::new(device, &DenoiserDescriptor::new(1920, 1080))?;
/// for inputs in frames {
///     let mut encoder = device.create_command_encoder(&Default::default());
///     check.encode(device, &mut encoder, inputs, &Settings::default())?; // beside the denoiser, or without it
///     queue.submit([encoder.finish()]);
///     device.poll(wgpu::PollType::wait_indefinitely())?; // or, while frames go on, poll now and then
/// }
/// check.findings().iter().for_each(|finding| eprintln!("{finding}"));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct InputCheck {
    size: [u32; 2],
    pass: Check,
    /// Surfaces and motion, of this frame and the one before in turns.
    kept: [[TextureView; 2]; 2],
    no_float: TextureView,
    no_uint: TextureView,
    /// The last frame and the one before it, as far as the sequence has no cut.
    previous: Option<Seen>,
    before: Option<Seen>,
    copies: Readback<()>,
    cameras: Cameras,
    evidence: Evidence,
    given: Given,
}

/// How a frame was seen.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// Right-handed.
    camera: Camera,
    /// In pixels.
    size: [u32; 2],
}

impl InputCheck {
    /// Compiles the pass and creates what is kept of two frames, 32 bytes a pixel.
    ///
    /// # Errors
    /// As [`Denoiser::new`](crate::Denoiser::new).
    pub fn new(device: &wgpu::Device, descriptor: &DenoiserDescriptor) -> Result<Self, CreateError> {
        layout::check(device, descriptor)?;
        check_alive(device)?;
        let size = [descriptor.width, descriptor.height];
        let kept = || {
            ["quell check guide", "quell check motion"]
                .map(|label| image(device, label, size, TextureFormat::Rg32Uint))
        };
        Ok(catch(device, || Self {
            size,
            pass: Check::new(device),
            kept: [kept(), kept()],
            no_float: image(device, "quell check no image", [1, 1], TextureFormat::Rgba16Float),
            no_uint: image(device, "quell check no ids", [1, 1], TextureFormat::R32Uint),
            previous: None,
            before: None,
            copies: Readback::default(),
            cameras: Cameras::default(),
            evidence: Evidence::default(),
            given: Given::default(),
        })?)
    }

    /// Records a pass that counts, for one frame with the inputs and settings that the denoiser gets. Its counts arrive once the
    /// caller's submission is done and the device was polled; of more than eight frames in flight the oldest are lost.
    ///
    /// # Errors
    /// As [`Denoiser::encode`](crate::Denoiser::encode), but a camera that would be taken with a matrix transposed is a
    /// [`Finding`], and the frame is left out.
    pub fn encode(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &FrameInputs<'_>,
        settings: &Settings,
    ) -> Result<(), FrameError> {
        let conventions = &settings.conventions;
        if inputs.camera.check(conventions).is_err()
            && self.cameras.is_transposed(&inputs.camera, conventions)
        {
            (self.previous, self.before) = (None, None);
            return Ok(());
        }
        let viewport = inputs.check(self.size, settings)?;
        self.collect();
        let now = Seen { camera: conventions.right_handed(&inputs.camera), size: viewport.size };
        let continues = inputs.history == HistoryMode::Continue;
        let previous = self.previous.filter(|_| continues);
        let before = self.before.filter(|_| continues);
        let frame = Self::uniforms(inputs, settings, &now, previous.as_ref(), viewport);
        let frame = &uniform_buffer(device, "quell check frame", bytemuck::bytes_of(&frame))?;
        let suspects = suspects(&now, previous.as_ref(), before.as_ref());
        let suspects = &uniform_buffer(device, "quell check suspects", bytemuck::bytes_of(&suspects))?;
        let usage = wgpu::BufferUsages::COPY_SRC;
        // A buffer of its own per frame, so that each frame's counts arrive apart; new ones are 0.
        let count = suspicion::STATISTICS as u64;
        let statistics = &catch(device, || words(device, "quell check statistics", count, usage))?;
        let [[guide, kept_motion], [previous_guide, previous_motion]] = &self.kept;
        let views = CheckViews {
            radiance: inputs.radiance,
            albedo: inputs.albedo,
            normal_roughness: inputs.normal_roughness,
            roughness: inputs.roughness.unwrap_or(&self.no_float),
            depth: inputs.depth,
            motion: inputs.motion,
            surface_id: inputs.surface_id.unwrap_or(&self.no_uint),
            emission: inputs.emission.unwrap_or(&self.no_float),
            sample_count: inputs.sample_count.unwrap_or(&self.no_uint),
            hit_distance: inputs.hit_distance.unwrap_or(&self.no_float),
            previous_guide,
            previous_motion,
            guide,
            kept_motion,
            suspects,
            statistics,
        };
        let mut recorder = Recorder { device, encoder, frame, profiler: None, is_specular: false };
        self.pass.record(&mut recorder, &views, viewport.size);
        self.copies.record(device, encoder, &[statistics], ());

        self.kept.swap(0, 1);
        (self.before, self.previous) = (previous, Some(now));
        let is_new = previous.is_none_or(|previous| previous.size != now.size);
        self.cameras.add(&now.camera, now.size, is_new);
        self.given.ids |= inputs.surface_id.is_some();
        self.given.emission |= inputs.emission.is_some();
        self.given.hit_distance |= inputs.hit_distance.is_some();
        Ok(())
    }

    /// What looks wrong in the frames whose counts have arrived, the most fundamental first. With one mistake mended, others
    /// may come to light that it hid.
    pub fn findings(&mut self) -> Vec<Finding> {
        self.collect();
        judge::findings(&self.evidence, &self.cameras)
    }

    /// Forgets all frames: after a mistake was mended.
    pub fn clear(&mut self) {
        (self.previous, self.before) = (None, None);
        self.copies = Readback::default();
        self.cameras = Cameras::default();
        self.evidence = Evidence::default();
        self.given = Given::default();
    }

    /// What could not be judged by these frames.
    pub fn untold(&mut self) -> Vec<Untold> {
        self.collect();
        judge::untold(&self.evidence, &self.cameras, self.given)
    }

    /// The numbers behind it.
    pub fn evidence(&mut self) -> &Evidence {
        self.collect();
        &self.evidence
    }

    /// Frames whose counts have arrived.
    pub fn frames(&mut self) -> u32 {
        self.collect();
        self.evidence.frames
    }

    fn collect(&mut self) {
        for words in self.copies.arrived::<u32>() {
            self.evidence.add(&words);
        }
    }

    fn uniforms(
        inputs: &FrameInputs<'_>,
        settings: &Settings,
        now: &Seen,
        previous: Option<&Seen>,
        viewport: Viewport,
    ) -> FrameUniforms {
        let Viewport { origin, size } = viewport;
        let mut uniforms = FrameUniforms {
            size,
            origin,
            tiles: layout::tiles(size),
            far: settings.far,
            flags: inputs.flags() | if previous.is_some() { flags::HISTORY } else { 0 },
            ..FrameUniforms::zeroed()
        };
        let before = previous.unwrap_or(now);
        uniforms.set_cameras(&now.camera, &before.camera, before.size);
        settings.conventions.enter(&mut uniforms, now.camera.clip_from_view);
        uniforms
    }
}

/// The cameras as they might be meant.
fn suspects(now: &Seen, previous: Option<&Seen>, before: Option<&Seen>) -> SuspectUniforms {
    let previous = previous.unwrap_or(now);
    let (inverse_current, inverse_previous, inverse_eye_delta) = pair(now, previous, inverse);
    let (turned_current, turned_previous, turned_eye_delta) = pair(now, previous, turned);
    // Motion is kept in pixels, which must not have changed.
    let before = before.filter(|before| before.size == previous.size && previous.size == now.size);
    let (_, view_before, before_eye_delta) = pair(previous, before.unwrap_or(previous), |camera| *camera);
    SuspectUniforms {
        inverse_current,
        inverse_previous,
        turned_current,
        turned_previous,
        before: view_before,
        inverse_eye_delta,
        turned_eye_delta,
        before_eye_delta,
        is_before_known: u32::from(before.is_some()),
        ..SuspectUniforms::zeroed()
    }
}

/// Two views and the eye's movement between them, of cameras that are meant to be something else.
fn pair(now: &Seen, previous: &Seen, meant: fn(&Camera) -> Camera) -> (ViewUniforms, ViewUniforms, Vec3) {
    let mut uniforms = FrameUniforms { size: now.size, ..FrameUniforms::zeroed() };
    uniforms.set_cameras(&meant(&now.camera), &meant(&previous.camera), previous.size);
    (uniforms.current, uniforms.previous, uniforms.eye_delta)
}

/// The camera if world from view was given.
fn inverse(camera: &Camera) -> Camera {
    let turned = Mat3::from_mat4(camera.view_from_world).transpose();
    let mut view_from_world = Mat4::from_mat3(turned);
    view_from_world.w_axis = (-(turned * camera.view_from_world.w_axis.truncate())).extend(1.0);
    Camera { view_from_world, ..*camera }
}

/// The camera if its rotation was given row by row.
fn turned(camera: &Camera) -> Camera {
    let mut view_from_world = Mat4::from_mat3(Mat3::from_mat4(camera.view_from_world).transpose());
    view_from_world.w_axis = camera.view_from_world.w_axis;
    Camera { view_from_world, ..*camera }
}
