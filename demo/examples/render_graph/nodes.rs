//! The nodes of a view: G-buffer, effect, quell, glow, tonemapping, and the way to the screen.

use crate::graph::{Graph, Node, Transient};
use crate::integrate::{Frame, GBUFFER, Renderer};
use quell::{Camera, Denoiser, FrameInputs, HistoryMode, PassProfiler, RequiredInputs, Settings, Viewport};
use wgpu::{BindingResource as Resource, TextureFormat as Format, TextureUsages as Usages, TextureView};

const GBUFFER_NAMES: [&str; 4] = ["albedo", "normal_roughness", "depth", "motion"];
pub const SCREEN: Format = Format::Rgba8Unorm;

fn target(format: Format) -> Transient {
    Transient { format, usage: Usages::RENDER_ATTACHMENT, shrink: 1 }
}

fn stored(format: Format) -> Transient {
    Transient { format, usage: Usages::STORAGE_BINDING, shrink: 1 }
}

/// What a view shows in a frame.
pub struct Shot<'a> {
    pub index: u32,
    pub frame: Frame,
    pub camera: Camera,
    /// Where on the screen: left, top, width, height.
    pub place: [f32; 4],
    pub denoise: bool,
    pub profiler: Option<&'a dyn PassProfiler>,
}

/// What a view keeps from frame to frame: history is quell's, not the graph's.
pub struct View {
    pub denoiser: Denoiser,
    /// The last frame that was denoised.
    pub denoised: Option<u32>,
}

impl View {
    pub fn graph<'a>(
        &'a mut self,
        renderer: &'a Renderer,
        post: &'a Post,
        screen: &'a TextureView,
        shot: &'a Shot<'a>,
    ) -> Graph<'a> {
        let Renderer { device, queue, .. } = renderer;
        let frame = &shot.frame;
        let lit = if shot.denoise { "denoised" } else { "noisy" };
        let [width, height] = frame.size;
        let mut graph = Graph::default();
        graph.import("screen", screen);

        let mut gbuffer = Node::new("gbuffer", move |encoder, textures| {
            let [a, n, d, m] = GBUFFER_NAMES.map(|name| textures.get(name));
            renderer.draw(encoder, frame, [a?, n?, d?, m?], textures.get("depth_buffer")?);
            Ok(())
        });
        for (name, format) in GBUFFER_NAMES.into_iter().zip(GBUFFER) {
            gbuffer = gbuffer.creates(name, target(format));
        }
        graph.add(gbuffer.creates("depth_buffer", target(Format::Depth32Float)));

        let trace = Node::new("trace", move |encoder, textures| {
            let [a, n, d] = ["albedo", "normal_roughness", "depth"].map(|name| textures.get(name));
            renderer.trace(encoder, frame, &[a?, n?, d?], textures.get("noisy")?);
            Ok(())
        });
        let trace = trace.reads(&["albedo", "normal_roughness", "depth"]);
        graph.add(trace.creates("noisy", stored(Format::Rgba16Float)));

        let denoise = Node::new("denoise", move |encoder, textures| {
            let inputs = FrameInputs::new(RequiredInputs {
                radiance: textures.get("noisy")?,
                albedo: textures.get("albedo")?,
                normal_roughness: textures.get("normal_roughness")?,
                depth: textures.get("depth")?,
                motion: textures.get("motion")?,
                output: textures.get("denoised")?,
                camera: shot.camera,
            });
            // While the node is culled, history gets old.
            let is_next = self.denoised.is_some_and(|last| last + 1 == shot.index);
            let history = if is_next { HistoryMode::Continue } else { HistoryMode::Restart };
            let mut inputs = inputs.with_history(history).with_viewport(Viewport::of_size(width, height));
            inputs.profiler = shot.profiler;
            self.denoiser.encode(device, queue, encoder, &inputs, &Settings::default())?;
            self.denoised = Some(shot.index);
            Ok(())
        });
        let denoise = denoise.reads(&GBUFFER_NAMES).reads(&["noisy"]);
        graph.add(denoise.creates("denoised", stored(Format::Rgba16Float)));

        let glow = Node::new("glow", move |encoder, textures| {
            let place = [0.0, 0.0, width.div_ceil(2) as f32, height.div_ceil(2) as f32];
            post.draw(
                renderer,
                encoder,
                &post.glow,
                frame,
                &[textures.get(lit)?],
                (textures.get("glow")?, place),
            );
            Ok(())
        });
        graph.add(glow.reads(&[lit]).creates("glow", Transient { shrink: 2, ..target(Format::Rgba16Float) }));

        let tonemap = Node::new("tonemap", move |encoder, textures| {
            let images = [textures.get(lit)?, textures.get("glow")?];
            let place = [0.0, 0.0, width as f32, height as f32];
            post.draw(renderer, encoder, &post.tonemap, frame, &images, (textures.get("picture")?, place));
            Ok(())
        });
        graph.add(tonemap.reads(&[lit, "glow"]).creates("picture", target(SCREEN)));

        let present = Node::new("present", move |encoder, textures| {
            let target = (textures.get("screen")?, shot.place);
            post.draw(renderer, encoder, &post.present, frame, &[textures.get("picture")?], target);
            Ok(())
        });
        graph.add(present.reads(&["picture"]).writes("screen"));
        graph
    }
}

/// The passes after quell.
pub struct Post {
    glow: wgpu::RenderPipeline,
    tonemap: wgpu::RenderPipeline,
    present: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
}

impl Post {
    pub fn new(device: &wgpu::Device) -> Self {
        let shader = concat!(include_str!("../boxes.wgsl"), include_str!("post.wgsl"));
        let module = &device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("post"),
            source: wgpu::ShaderSource::Wgsl(shader.into()),
        });
        let pipeline = |name, format: Format| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(name),
                layout: None,
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some("screen"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module,
                    entry_point: Some(name),
                    compilation_options: Default::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self {
            glow: pipeline("glow", Format::Rgba16Float),
            tonemap: pipeline("tonemap_glow", SCREEN),
            present: pipeline("present", SCREEN),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
        }
    }

    /// Fills a place (left, top, width, height) of an image from others.
    fn draw(
        &self,
        renderer: &Renderer,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::RenderPipeline,
        frame: &Frame,
        images: &[&TextureView],
        (view, [left, top, width, height]): (&TextureView, [f32; 4]),
    ) {
        let mut rest = vec![Resource::TextureView(images[0]), Resource::Sampler(&self.sampler)];
        rest.extend(images[1..].iter().map(|image| Resource::TextureView(image)));
        let bindings = renderer.bind(pipeline.get_bind_group_layout(0), frame, &rest);
        let ops = wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops,
            })],
            ..Default::default()
        });
        pass.set_viewport(left, top, width, height, 0.0, 1.0);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        pass.draw(0..3, 0..1);
    }
}
