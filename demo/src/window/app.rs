//! The event loop.

use super::running::Running;
use super::{FrameSource, WindowError, WindowOptions};
use crate::gpu::Gpu;
use anyhow::Context;
use glam::Vec2;
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{DeviceEvent, DeviceId, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowId};

/// Opens a window and runs until it is closed. `make_source` gets the device that the window presents with.
///
/// Only once per process, on the main thread: window systems want it so.
pub fn run<S: FrameSource>(
    options: WindowOptions,
    make_source: impl FnOnce(&Gpu) -> anyhow::Result<S>,
) -> Result<(), WindowError> {
    let event_loop = EventLoop::new().map_err(|error| no_display(&error))?;
    let mut app = App { options, make_source: Some(make_source), running: None, error: None };
    event_loop.run_app(&mut app).context("the window system failed")?;
    app.error.map_or(Ok(()), Err)
}

/// Without the place in the window library's source that its messages begin with.
fn no_display(error: &dyn std::error::Error) -> WindowError {
    let message = error.to_string();
    WindowError::NoDisplay(
        message
            .rsplit_once(".rs:")
            .map_or(message.as_str(), |(_, rest)| rest.split_once(": ").map_or(rest, |(_, reason)| reason))
            .to_owned(),
    )
}

struct App<S, F> {
    options: WindowOptions,
    /// Until the window exists.
    make_source: Option<F>,
    running: Option<Running<S>>,
    /// Why the loop ended.
    error: Option<WindowError>,
}

impl<S: FrameSource, F: FnOnce(&Gpu) -> anyhow::Result<S>> App<S, F> {
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), WindowError> {
        let Some(make_source) = self.make_source.take() else {
            return Ok(());
        };
        let attributes = Window::default_attributes()
            .with_title(&self.options.title)
            .with_inner_size(LogicalSize::new(self.options.size[0], self.options.size[1]));
        let window = event_loop.create_window(attributes).map_err(|error| no_display(&error))?;
        let display = event_loop.owned_display_handle();
        self.running = Some(Running::new(window, display, &self.options, make_source)?);
        Ok(())
    }

    fn end_with(&mut self, event_loop: &ActiveEventLoop, error: WindowError) {
        self.error = Some(error);
        event_loop.exit();
    }
}

impl<S: FrameSource, F: FnOnce(&Gpu) -> anyhow::Result<S>> ApplicationHandler for App<S, F> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if let Err(error) = self.open(event_loop) {
            self.end_with(event_loop, error);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(running) = &mut self.running else {
            return;
        };
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => match running.draw() {
                Ok(frames) if self.options.max_frames.is_some_and(|max| frames >= max) => event_loop.exit(),
                Ok(_) => {}
                Err(error) => self.end_with(event_loop, error.into()),
            },
            event => {
                if running.handle(&event) {
                    event_loop.exit();
                }
            }
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let (Some(running), DeviceEvent::MouseMotion { delta }) = (&mut self.running, event) {
            running.mouse_moved(Vec2::new(delta.0 as f32, delta.1 as f32));
        }
    }

    fn about_to_wait(&mut self, _: &ActiveEventLoop) {
        if let Some(running) = &self.running {
            running.request_redraw();
        }
    }
}
