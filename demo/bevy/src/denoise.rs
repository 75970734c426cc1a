//! One view's frame, from bevy's images to quell's call.

use crate::Refusal;
use crate::component::{QuellLight, QuellSignal};
use crate::conventions::{camera, conventions};
use crate::decode::DecodeFrame;
use crate::extract::ExtractedQuell;
use crate::timings::Timings;
use crate::view::{FrameId, QuellView, Shared, ViewState};
use bevy::asset::Handle;
use bevy::camera::MainPassResolutionOverride;
use bevy::core_pipeline::core_3d::Opaque3d;
use bevy::core_pipeline::deferred::Opaque3dDeferred;
use bevy::core_pipeline::prepass::ViewPrepassTextures;
use bevy::diagnostic::FrameCount;
use bevy::ecs::query::QueryData;
use bevy::ecs::system::{Res, SystemParam};
use bevy::image::Image;
use bevy::render::camera::{ExtractedCamera, TemporalJitter};
use bevy::render::diagnostic::RecordDiagnostics;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_phase::ViewBinnedRenderPhases;
use bevy::render::render_resource::TextureView as BevyView;
use bevy::render::renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery};
use bevy::render::texture::GpuImage;
use bevy::render::view::{ExtractedView, ViewTarget};
use quell::wgpu::{TextureFormat, TextureView};
use quell::{Camera, FrameInputs, FrameOutputs, HistoryMode, RequiredInputs, Settings, Viewport};

/// What bevy knows of a view.
#[derive(QueryData)]
pub struct View {
    quell: &'static ExtractedQuell,
    state: &'static QuellView,
    camera: &'static ExtractedCamera,
    view: &'static ExtractedView,
    target: &'static ViewTarget,
    prepass: Option<&'static ViewPrepassTextures>,
    resolution: Option<&'static MainPassResolutionOverride>,
    jitter: Option<&'static TemporalJitter>,
}

/// What is the same for all views.
#[derive(SystemParam)]
pub struct Gpu<'w> {
    opaque: Res<'w, ViewBinnedRenderPhases<Opaque3d>>,
    deferred: Res<'w, ViewBinnedRenderPhases<Opaque3dDeferred>>,
    device: Res<'w, RenderDevice>,
    queue: Res<'w, RenderQueue>,
    shared: Res<'w, Shared>,
    images: Res<'w, RenderAssets<GpuImage>>,
    frame: Res<'w, FrameCount>,
}

/// The system: denoises the current view, or says why not.
pub fn denoise(view: ViewQuery<View>, gpu: Gpu, mut ctx: RenderContext) {
    let view = view.into_inner();
    let entity = view.view.retained_view_entity.main_entity.id();
    let mut state = view.state.state();
    let outcome = denoise_view(&view, &mut state, &gpu, &mut ctx);
    state.report(entity, outcome, draws_forward_only(&view, &gpu));
}

/// Whether nothing that the view sees is in its G-buffer, which users forget to ask for.
fn draws_forward_only(view: &ViewItem<'_, '_>, gpu: &Gpu) -> bool {
    let entity = &view.view.retained_view_entity;
    let is_drawn = gpu.opaque.get(entity).is_some_and(|phase| !phase.is_empty());
    is_drawn && gpu.deferred.get(entity).is_none_or(|phase| phase.is_empty())
}

fn denoise_view(
    view: &ViewItem<'_, '_>,
    state: &mut ViewState,
    gpu: &Gpu,
    ctx: &mut RenderContext,
) -> Result<FrameOutputs, Refusal> {
    let quell = &view.quell.0;
    let [gbuffer, depth, motion] = prepasses(view)?;
    let images = Images::of(view, &gpu.images)?;
    let (device, queue) = (gpu.device.wgpu_device(), &**gpu.queue);

    let now = FrameId::new(gpu.frame.0, quell);
    let continues = state.last.as_ref().is_some_and(|last| now.continues(last));
    let compiled = gpu.shared.compiled(device)?;
    let target_size = [gbuffer.texture().width(), gbuffer.texture().height()];
    let resources = state.resources(device, compiled, [full_size(view), target_size])?;
    resources.serve(device, quell)?;

    let recorder = ctx.diagnostic_recorder();
    let recorder = recorder.as_deref();
    let timings = recorder.map(|recorder| Timings::new(recorder, quell));
    let encoder = ctx.command_encoder();
    let span = recorder.time_span(encoder, "quell");

    let frame = DecodeFrame {
        clip_from_view: view.view.clip_from_view.to_cols_array(),
        viewport: viewport(view),
        emission_scale: quell.light.emission_scale(view.camera.exposure),
        has_albedo: quell.light != QuellLight::Incident,
    };
    let decoded = &resources.decoded;
    resources.compiled.decoder.record((device, queue), encoder, [&gbuffer, &depth], &frame, decoded);

    // A debug view takes the place of the denoised image.
    let shown = images.denoised.as_ref().or(resources.shown.as_ref()).expect("`serve` made it for the view");
    let output = resources.hidden.as_ref().unwrap_or(shown);
    let debug = quell.debug.map(|debug| (debug, shown));
    let mut inputs = FrameInputs::new(RequiredInputs {
        radiance: &images.radiance,
        albedo: &decoded.albedo,
        normal_roughness: &decoded.normal_roughness,
        depth: &decoded.depth,
        motion: &motion,
        output,
        camera: camera_of(view),
    })
    .with_history(if continues { HistoryMode::Continue } else { HistoryMode::Restart })
    .with_viewport(frame.viewport)
    .with_emission((frame.emission_scale != 0.0).then_some(&decoded.emission))
    .with_specular(images.specular.as_ref())
    .with_hit_distance(images.hit_distance.as_ref())
    .with_surface_id(images.surface_id.as_ref())
    .with_sample_count(images.sample_count.as_ref())
    .with_debug(debug);
    if let Some(timings) = &timings {
        inputs = inputs.with_profiler(timings);
    }
    let settings = Settings::from(quell.settings).with_conventions(conventions());
    let outcome = resources.denoiser.encode(device, queue, encoder, &inputs, &settings);
    if outcome.is_ok() && images.denoised.is_none() {
        resources.compiled.show.record(device, encoder, shown, &images.radiance, frame.viewport);
    }
    span.end(encoder);
    let outputs = outcome?;
    if let Some(check) = &mut resources.check {
        check.encode(device, encoder, &inputs, &settings)?;
    }
    state.last = Some(now);
    Ok(outputs)
}

/// G-buffer, depth, motion.
fn prepasses(view: &ViewItem<'_, '_>) -> Result<[TextureView; 3], Refusal> {
    let prepass = view.prepass;
    let found = |name, image: Option<&BevyView>| image.map(wgpu_view).ok_or(Refusal::Prepass(name));
    Ok([
        found("DeferredPrepass", prepass.and_then(ViewPrepassTextures::deferred_view))?,
        found("DepthPrepass", prepass.and_then(ViewPrepassTextures::depth_only_view))?,
        found("MotionVectorPrepass", prepass.and_then(ViewPrepassTextures::motion_vectors_view))?,
    ])
}

/// The signal's images.
struct Images {
    radiance: TextureView,
    /// None where it replaces `radiance`, in the view target.
    denoised: Option<TextureView>,
    specular: Option<TextureView>,
    hit_distance: Option<TextureView>,
    surface_id: Option<TextureView>,
    sample_count: Option<TextureView>,
}

impl Images {
    fn of(view: &ViewItem<'_, '_>, assets: &RenderAssets<GpuImage>) -> Result<Self, Refusal> {
        let image = |name, handle: &Handle<Image>| {
            assets.get(handle).map(|image| wgpu_view(&image.texture_view)).ok_or(Refusal::Image(name))
        };
        let optional = |name, handle: &Option<Handle<Image>>| {
            handle.as_ref().map(|handle| image(name, handle)).transpose()
        };
        match &view.quell.0.signal {
            QuellSignal::View => {
                let format = view.target.main_texture_format();
                if format != TextureFormat::Rgba16Float {
                    return Err(Refusal::NotHdr(format!("{format:?}")));
                }
                Ok(Self {
                    radiance: wgpu_view(view.target.main_texture_view()),
                    denoised: None,
                    specular: None,
                    hit_distance: None,
                    surface_id: None,
                    sample_count: None,
                })
            }
            QuellSignal::Images(images) => Ok(Self {
                radiance: image("radiance", &images.radiance)?,
                denoised: Some(image("denoised", &images.denoised)?),
                specular: optional("specular", &images.specular)?,
                hit_distance: optional("hit_distance", &images.hit_distance)?,
                surface_id: optional("surface_id", &images.surface_id)?,
                sample_count: optional("sample_count", &images.sample_count)?,
            }),
        }
    }
}

fn wgpu_view(view: &BevyView) -> TextureView {
    (**view).clone()
}

fn camera_of(view: &ViewItem<'_, '_>) -> Camera {
    let world_from_view = view.view.world_from_view.to_matrix();
    let jitter = view.jitter.map_or([0.0; 2], |jitter| jitter.offset.to_array());
    camera(world_from_view.to_cols_array(), view.view.clip_from_view.to_cols_array(), jitter)
}

/// The largest size that this view's frames have: without dynamic resolution.
fn full_size(view: &ViewItem<'_, '_>) -> [u32; 2] {
    [view.view.viewport.z, view.view.viewport.w]
}

/// The part of the images that this frame is.
fn viewport(view: &ViewItem<'_, '_>) -> Viewport {
    let origin = [view.view.viewport.x, view.view.viewport.y];
    let size = view.resolution.map_or(full_size(view), |resolution| resolution.0.to_array());
    Viewport { origin, size }
}
