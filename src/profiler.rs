//! Timing the passes with the caller's own means.

use crate::PASSES;
use std::fmt::Debug;

/// What times the passes of a frame, or marks them: timestamp queries of the caller's profiler, zones of a CPU profiler.
/// [`Timestamps`] is the plain one.
///
/// Both calls come between compute passes, once for each name of [`PASSES`], also for a pass that has nothing to do in the frame;
/// in that order, but `debug_view` comes before the specular passes where it shows what is gone after them.
pub trait PassProfiler: Debug {
    /// Before the pass is begun. What is returned becomes its `timestamp_writes`.
    fn begin(&self, pass: &'static str, encoder: &mut wgpu::CommandEncoder) -> Option<PassTimestamps>;

    /// After the pass has ended.
    fn end(&self, pass: &'static str, encoder: &mut wgpu::CommandEncoder) {
        let _ = (pass, encoder);
    }
}

/// Queries that one pass writes. The set needs `Features::TIMESTAMP_QUERY`.
#[derive(Debug, Clone)]
pub struct PassTimestamps {
    /// A set of timestamp queries.
    pub query_set: wgpu::QuerySet,
    /// Query that receives the begin of the pass.
    pub begin: Option<u32>,
    /// Query that receives its end.
    pub end: Option<u32>,
}

/// Writes timestamps one behind the other: pass `i` of [`PASSES`] begins at query `first_query + 2 i` and ends at the one
/// after it, also where it has nothing to do. On CPU adapters timestamps do not wait for compute passes and tell little.
#[derive(Debug, Clone, Copy)]
pub struct Timestamps<'a> {
    /// A set of timestamp queries with at least `first_query + 2 * PASSES.len()` entries.
    pub query_set: &'a wgpu::QuerySet,
    /// Query that receives the begin of the first pass.
    pub first_query: u32,
}

impl PassProfiler for Timestamps<'_> {
    fn begin(&self, pass: &'static str, _: &mut wgpu::CommandEncoder) -> Option<PassTimestamps> {
        let place = PASSES.iter().position(|name| *name == pass)?;
        let begin = self.first_query + 2 * u32::try_from(place).ok()?;
        Some(PassTimestamps { query_set: self.query_set.clone(), begin: Some(begin), end: Some(begin + 1) })
    }
}
