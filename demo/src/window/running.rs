//! An open window: its surface, panel and source, and one frame from top to bottom.

use super::controls::{Action, Controls, is_ours};
use super::display::{DisplayPass, Shown, letterbox};
use super::free_flight::FreeFlight;
use super::panel::{GRAPH_FRAMES, PanelInfo, panel};
use super::ui_layer::{PanelOutput, UiLayer};
use super::{FrameImages, FrameRequest, FrameSource, ViewMode, ViewState, WindowOptions};
use crate::gpu::Gpu;
use crate::gpu_timer::GpuTimer;
use anyhow::{Context, Result, bail};
use glam::{Mat4, Vec2};
use quell::DebugView;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};
use wgpu::CurrentSurfaceTexture;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, MouseButton, WindowEvent};
use winit::event_loop::OwnedDisplayHandle;
use winit::keyboard::PhysicalKey;
use winit::window::{CursorGrabMode, Window};

/// Passes of a frame that can be timed: the denoiser's, a tracer's and some more.
const TIMED_PASSES: u32 = 64;
/// Pause where nothing can be drawn, so that the loop does not spin.
const IDLE: Duration = Duration::from_millis(16);
/// A stall must not fly the camera through a wall; a CPU adapter's frames must still get it somewhere.
const LONGEST_FLIGHT_S: f32 = 0.5;

pub struct Running<S> {
    window: Arc<Window>,
    /// In pixels, as last reported; 0 while minimised on some systems.
    size: PhysicalSize<u32>,
    gpu: Gpu,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    display: DisplayPass,
    ui: UiLayer,
    source: S,
    timer: GpuTimer,
    view: ViewState,
    controls: Controls,
    /// While `ViewState::free_flight` is on.
    flight: Option<FreeFlight>,
    speed: f32,
    last_view: Mat4,
    status: String,
    device: String,
    frame_times_s: VecDeque<f32>,
    last_frame: Instant,
    frames: u64,
    /// Part of the window that the panel leaves, in pixels: left, top, width, height.
    image_area: [f32; 4],
    /// Part of it that the image fills.
    image_rect: [f32; 4],
    cursor: Vec2,
}

impl<S: FrameSource> Running<S> {
    pub fn new(
        window: Window,
        display_handle: OwnedDisplayHandle,
        options: &WindowOptions,
        make_source: impl FnOnce(&Gpu) -> Result<S>,
    ) -> Result<Self> {
        let window = Arc::new(window);
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_with_display_handle(Box::new(display_handle)));
        let surface = instance.create_surface(Arc::clone(&window)).context("cannot draw to the window")?;
        let gpu = Gpu::on(instance, Some(&surface))?;
        let config = configuration(&gpu, &surface)?;
        let display = DisplayPass::new(&gpu.device, config.format);
        let ui = UiLayer::new(&gpu, &window, config.format);
        let source = make_source(&gpu)?;
        let mut running = Self {
            timer: GpuTimer::new(&gpu.device, &gpu.queue, TIMED_PASSES),
            device: gpu.description(),
            size: window.inner_size(),
            window,
            gpu,
            surface,
            config,
            display,
            ui,
            source,
            view: options.view.clone(),
            controls: Controls::default(),
            flight: None,
            speed: options.speed,
            last_view: Mat4::IDENTITY,
            status: String::new(),
            frame_times_s: VecDeque::with_capacity(GRAPH_FRAMES),
            last_frame: Instant::now(),
            frames: 0,
            image_area: [0.0; 4],
            image_rect: [0.0; 4],
            cursor: Vec2::ZERO,
        };
        running.configure();
        Ok(running)
    }

    pub fn request_redraw(&self) {
        // Nothing to draw on while minimised: the next event wakes the loop.
        if self.has_area() {
            self.window.request_redraw();
        }
    }

    fn has_area(&self) -> bool {
        self.size.width > 0 && self.size.height > 0
    }

    fn configure(&mut self) {
        if !self.has_area() {
            return;
        }
        let size = self.size;
        let largest = self.gpu.device.limits().max_texture_dimension_2d;
        (self.config.width, self.config.height) = (size.width.min(largest), size.height.min(largest));
        self.surface.configure(&self.gpu.device, &self.config);
    }

    pub fn mouse_moved(&mut self, delta: Vec2) {
        self.controls.mouse_moved(delta);
    }

    /// Handles any other event; true to quit.
    pub fn handle(&mut self, event: &WindowEvent) -> bool {
        let context = self.ui.context().clone();
        if let WindowEvent::KeyboardInput { event: key, .. } = event
            && let PhysicalKey::Code(code) = key.physical_key
            && is_ours(code)
            // A menu closes with Esc, a number is typed in digits.
            && !context.egui_wants_keyboard_input()
            && !egui::Popup::is_any_open(&context)
        {
            match key.state {
                ElementState::Pressed => match self.controls.press(code, key.repeat, &mut self.view) {
                    Some(Action::Quit) => return true,
                    Some(Action::ToggleMouseCapture) => self.capture_mouse(!self.controls.captured),
                    None => {}
                },
                ElementState::Released => self.controls.release(code),
            }
            return false;
        }
        // What it needs of an event egui knows itself; whether it also is ours depends on where the pointer is.
        self.ui.handle(&self.window, event);
        match event {
            WindowEvent::Resized(size) => {
                self.size = *size;
                self.configure();
            }
            WindowEvent::Destroyed => return true,
            WindowEvent::Focused(false) => {
                self.capture_mouse(false);
                self.controls.release_all();
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.cursor = Vec2::new(position.x as f32, position.y as f32);
                self.drag_split();
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let pressed = *state == ElementState::Pressed;
                // A release always counts, wherever it happens.
                let pressed_here = pressed && self.is_on_image(&context);
                match button {
                    MouseButton::Right if pressed_here || !pressed => self.controls.looking = pressed,
                    MouseButton::Left if pressed_here || !pressed => {
                        self.controls.dragging_split = pressed && self.view.mode == ViewMode::Split;
                        self.drag_split();
                    }
                    _ => {}
                }
            }
            _ => {}
        }
        false
    }

    /// Whether the pointer is on the image, and not on the panel or a menu that hangs over the image.
    fn is_on_image(&self, context: &egui::Context) -> bool {
        let [left, top, width, height] = self.image_area;
        let inside =
            (left..left + width).contains(&self.cursor.x) && (top..top + height).contains(&self.cursor.y);
        let scale = context.pixels_per_point();
        let layer = context.layer_id_at(egui::pos2(self.cursor.x / scale, self.cursor.y / scale));
        inside && layer.is_none_or(|layer| layer.order == egui::Order::Background)
    }

    fn drag_split(&mut self) {
        let [left, _, width, _] = self.image_rect;
        if self.controls.dragging_split && width > 0.0 {
            self.view.split = ((self.cursor.x - left) / width).clamp(0.0, 1.0);
        }
    }

    fn capture_mouse(&mut self, capture: bool) {
        let grab = if capture {
            // Not every window system has both.
            self.window
                .set_cursor_grab(CursorGrabMode::Locked)
                .or_else(|_| self.window.set_cursor_grab(CursorGrabMode::Confined))
        } else {
            self.window.set_cursor_grab(CursorGrabMode::None)
        };
        self.controls.captured = capture && grab.is_ok();
        self.window.set_cursor_visible(!self.controls.captured);
    }

    /// Draws one frame, where there is something to draw on. Returns the number of frames so far.
    pub fn draw(&mut self) -> Result<u64> {
        if !self.has_area() {
            return Ok(self.frames);
        }
        let (target, suboptimal) = match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture) => (texture, false),
            CurrentSurfaceTexture::Suboptimal(texture) => (texture, true),
            CurrentSurfaceTexture::Outdated => {
                self.configure();
                return Ok(self.frames);
            }
            CurrentSurfaceTexture::Lost => {
                self.surface = self
                    .gpu
                    .instance
                    .create_surface(Arc::clone(&self.window))
                    .context("the window's surface was lost")?;
                self.configure();
                return Ok(self.frames);
            }
            CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Occluded => {
                std::thread::sleep(IDLE);
                return Ok(self.frames);
            }
            CurrentSurfaceTexture::Validation => bail!("the window's surface cannot be drawn to"),
        };
        let elapsed_s = self.tick();
        let ui = self.run_panel();
        let target_view = target.texture.create_view(&Default::default());
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        let images = self.render_source(&mut encoder, elapsed_s, ui.area)?;
        self.show(&mut encoder, &target_view, &images, ui.area);
        let mut commands = self.ui.draw(&self.gpu, &mut encoder, &target_view, ui);
        self.timer.resolve(&mut encoder);
        commands.push(encoder.finish());
        self.gpu.queue.submit(commands);
        self.timer.submitted();
        self.window.pre_present_notify();
        self.gpu.queue.present(target);
        if suboptimal {
            self.configure();
        }
        self.last_view = images.view_from_world;
        self.status = images.status;
        self.frames += 1;
        Ok(self.frames)
    }

    /// Seconds since the last frame.
    fn tick(&mut self) -> f32 {
        let now = Instant::now();
        let elapsed_s = now.duration_since(self.last_frame).as_secs_f32();
        self.last_frame = now;
        if self.frames > 0 {
            if self.frame_times_s.len() == GRAPH_FRAMES {
                self.frame_times_s.pop_front();
            }
            self.frame_times_s.push_back(elapsed_s);
        }
        elapsed_s
    }

    fn run_panel(&mut self) -> PanelOutput {
        let info = PanelInfo {
            device: &self.device,
            status: &self.status,
            passes: self.timer.poll(&self.gpu.device),
            frame_times_s: &self.frame_times_s,
        };
        let size = [self.config.width, self.config.height];
        self.ui.run(&self.window, size, |ui| panel(ui, &mut self.view, &info))
    }

    fn render_source(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        elapsed_s: f32,
        area: [f32; 4],
    ) -> Result<FrameImages> {
        let input = self.controls.take_flight_input();
        self.flight = self.view.free_flight.then(|| {
            let mut flight = self.flight.unwrap_or_else(|| FreeFlight::from_view(self.last_view, self.speed));
            flight.advance(&input, elapsed_s.min(LONGEST_FLIGHT_S));
            flight
        });
        let time_step_s = self.view.take_time_step(elapsed_s);
        let restart = std::mem::take(&mut self.view.restart);
        let request = FrameRequest {
            view: &self.view,
            time_step_s,
            free_view: self.flight.map(|flight| flight.view()),
            restart,
            area: [(area[2] as u32).max(1), (area[3] as u32).max(1)],
        };
        self.source.frame(&self.gpu, encoder, &request, &mut self.timer)
    }

    fn show(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        images: &FrameImages,
        area: [f32; 4],
    ) {
        let image = |mode| match mode {
            ViewMode::Noisy => images.noisy.as_ref(),
            ViewMode::Rival => images.rival.as_ref(),
            ViewMode::Reference => images.reference.as_ref(),
            ViewMode::Denoised | ViewMode::Split => None,
        };
        let image = |mode| image(mode).unwrap_or(&images.denoised);
        let debug = self.view.debug.zip(images.debug.as_ref());
        let [left, right] = self.view.split_sides;
        let shown = Shown {
            left: match (debug, self.view.mode) {
                (Some((_, view)), _) => view,
                (None, ViewMode::Split) => image(left),
                (None, mode) => image(mode),
            },
            right: (debug.is_none() && self.view.mode == ViewMode::Split)
                .then(|| (image(right), self.view.split)),
            exposure: self.view.exposure_ev.exp2(),
            tonemap: debug
                .is_none_or(|(debug, _)| matches!(debug, DebugView::Prediction | DebugView::TemporalMean)),
        };
        let texture = shown.left.texture();
        self.image_area = area;
        self.image_rect = letterbox([texture.width() as f32, texture.height() as f32], area);
        self.display.draw(&self.gpu.device, &self.gpu.queue, encoder, target, area, Some(&shown));
    }
}

fn configuration(gpu: &Gpu, surface: &wgpu::Surface<'_>) -> Result<wgpu::SurfaceConfiguration> {
    let mut config = surface
        .get_default_config(&gpu.adapter, 1, 1)
        .with_context(|| format!("{} cannot present to this window", gpu.description()))?;
    // The panel's colours are blended as they are encoded, so a format that does not encode by itself is better.
    let formats = surface.get_capabilities(&gpu.adapter).formats;
    let plain = [wgpu::TextureFormat::Bgra8Unorm, wgpu::TextureFormat::Rgba8Unorm];
    if let Some(format) = formats.into_iter().find(|format| plain.contains(format)) {
        config.format = format;
    }
    config.present_mode = wgpu::PresentMode::AutoVsync;
    Ok(config)
}
