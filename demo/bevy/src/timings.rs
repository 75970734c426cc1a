//! quell's passes under bevy's render diagnostics.

use crate::{Quell, QuellSignal};
use bevy::render::diagnostic::{DiagnosticsRecorder, RecordDiagnostics, TimeSpanGuard};
use quell::wgpu::CommandEncoder;
use quell::{PassProfiler, PassTimestamps};
use std::cell::RefCell;
use std::fmt;

/// One span a pass, for the passes that have something to do.
pub struct Timings<'a> {
    recorder: &'a DiagnosticsRecorder,
    is_split: bool,
    has_debug: bool,
    open: RefCell<Option<TimeSpanGuard<'a, DiagnosticsRecorder, CommandEncoder>>>,
}

impl<'a> Timings<'a> {
    pub fn new(recorder: &'a DiagnosticsRecorder, quell: &Quell) -> Self {
        let is_split = matches!(&quell.signal, QuellSignal::Images(images) if images.specular.is_some());
        Self { recorder, is_split, has_debug: quell.debug.is_some(), open: RefCell::default() }
    }

    fn has_work(&self, pass: &str) -> bool {
        match pass {
            "debug_view" => self.has_debug,
            "sample_map" => false,
            _ => self.is_split || !pass.starts_with("specular"),
        }
    }
}

impl PassProfiler for Timings<'_> {
    fn begin(&self, pass: &'static str, encoder: &mut CommandEncoder) -> Option<PassTimestamps> {
        if self.has_work(pass) {
            *self.open.borrow_mut() = Some(self.recorder.time_span(encoder, pass));
        }
        None
    }

    fn end(&self, _: &'static str, encoder: &mut CommandEncoder) {
        if let Some(span) = self.open.take() {
            span.end(encoder);
        }
    }
}

impl fmt::Debug for Timings<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Timings").finish_non_exhaustive()
    }
}
