//! egui between the window and the GPU: events in, shapes out.

use crate::gpu::Gpu;
use egui_wgpu::ScreenDescriptor;
use winit::event::WindowEvent;
use winit::window::Window;

pub struct UiLayer {
    state: egui_winit::State,
    renderer: egui_wgpu::Renderer,
}

/// A frame of the user interface, to be drawn in the same frame: egui insists that its textures are uploaded.
pub struct PanelOutput {
    output: egui::FullOutput,
    screen: ScreenDescriptor,
    /// What the panel leaves for the image, in pixels: left, top, width, height.
    pub area: [f32; 4],
}

impl UiLayer {
    pub fn new(gpu: &Gpu, window: &Window, format: wgpu::TextureFormat) -> Self {
        let state = egui_winit::State::new(
            egui::Context::default(),
            egui::ViewportId::ROOT,
            window,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(gpu.device.limits().max_texture_dimension_2d as usize),
        );
        Self { state, renderer: egui_wgpu::Renderer::new(&gpu.device, format, Default::default()) }
    }

    pub fn context(&self) -> &egui::Context {
        self.state.egui_ctx()
    }

    /// Gives egui an event. Whether it is also the window's depends on where the pointer is, which the window knows.
    pub fn handle(&mut self, window: &Window, event: &WindowEvent) {
        let _ = self.state.on_window_event(window, event);
    }

    /// Lays the interface out over `size_px`. `contents` returns the part that it leaves, in points.
    pub fn run(
        &mut self,
        window: &Window,
        size_px: [u32; 2],
        mut contents: impl FnMut(&mut egui::Ui) -> egui::Rect,
    ) -> PanelOutput {
        let input = self.state.take_egui_input(window);
        let mut rest = egui::Rect::NOTHING;
        let mut output = self.state.egui_ctx().clone().run_ui(input, |ui| rest = contents(ui));
        self.state.handle_platform_output(window, std::mem::take(&mut output.platform_output));
        let scale = output.pixels_per_point;
        let [width, height] = size_px.map(|side| side as f32);
        let (left, top) = ((rest.left() * scale).clamp(0.0, width), (rest.top() * scale).clamp(0.0, height));
        let (right, bottom) = ((rest.right() * scale).min(width), (rest.bottom() * scale).min(height));
        PanelOutput {
            screen: ScreenDescriptor { size_in_pixels: size_px, pixels_per_point: scale },
            output,
            area: [left, top, (right - left).max(0.0), (bottom - top).max(0.0)],
        }
    }

    /// Draws over what `target` holds. The command buffers that come back go before `encoder`'s.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        ui: PanelOutput,
    ) -> Vec<wgpu::CommandBuffer> {
        let PanelOutput { mut output, screen, .. } = ui;
        for (id, deltas) in output.textures_delta.set.drain() {
            for delta in deltas {
                self.renderer.update_texture(&gpu.device, &gpu.queue, id, &delta);
            }
        }
        let shapes = std::mem::take(&mut output.shapes);
        let jobs = self.context().tessellate(shapes, output.pixels_per_point);
        let commands = self.renderer.update_buffers(&gpu.device, &gpu.queue, encoder, &jobs, &screen);
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("panel"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        self.renderer.render(&mut pass.forget_lifetime(), &jobs, &screen);
        for id in output.textures_delta.free.drain() {
            self.renderer.free_texture(&id);
        }
        commands
    }
}
