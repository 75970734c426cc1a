//! Places centres level by level and fits a model at each. See `shaders/centres.wgsl` and `shaders/fit.wgsl`.

use super::{centres, choose, gains};
use crate::gpu::{Compiler, Kernel, KernelDescriptor, Kind, Recorder};
use crate::layout::{LEVEL_STRIDES, LEVEL_WORDS, LEVELS};
use wgpu::util::DeviceExt;
use wgpu::{BindGroup, Buffer};

/// What fits the models of a level.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "fit",
    source: include_str!("../../shaders/fit.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("level", Kind::Uniform),
        ("moments", Kind::Buffer),
        ("centre_list", Kind::Buffer),
        ("levels", Kind::Buffer),
        ("models", Kind::BufferMut),
        ("windows", Kind::BufferMut),
        ("coverage", Kind::BufferMut),
        ("kept", Kind::Buffer),
    ],
    workgroup: [32, 1],
    covers: [1, 1],
};

/// What the pass reads and writes; named as in the WGSL. `windows`, `coverage`, `levels` and `histogram` are 0
/// before it, and `kept` is what `windows` was in the frame before,
/// of which a limited frame forgets the models that hold no longer.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct FitViews<'a> {
    pub moments: &'a Buffer,
    pub centre_list: &'a Buffer,
    pub levels: &'a Buffer,
    pub models: &'a Buffer,
    pub windows: &'a Buffer,
    pub coverage: &'a Buffer,
    pub kept: &'a Buffer,
    pub histogram: &'a Buffer,
}

/// The pass: for each level, a dispatch that lists centres and one that fits their models. Under a budget, two list the centres
/// of all levels but the coarsest.
#[derive(Debug, Clone)]
pub struct Fit {
    centres: Kernel,
    gains: Kernel,
    choose: Kernel,
    fit: Kernel,
    /// The number of each level.
    numbers: [Buffer; LEVELS],
}

impl Fit {
    /// Compiles the pass.
    pub fn new<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        let compiler = compiler.into();
        let number = |level: usize| {
            compiler.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("quell level"),
                contents: bytemuck::cast_slice(&[level as u32, 0, 0, 0]),
                usage: wgpu::BufferUsages::UNIFORM,
            })
        };
        Self {
            centres: Kernel::new(compiler, &centres::DESCRIPTOR),
            gains: Kernel::new(compiler, &gains::DESCRIPTOR),
            choose: Kernel::new(compiler, &choose::DESCRIPTOR),
            fit: Kernel::new(compiler, &DESCRIPTOR),
            numbers: std::array::from_fn(number),
        }
    }

    /// Records the pass over `extent` tiles; `limited` where the frame's flag `LIMITED` is set.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &FitViews<'_>, extent: [u32; 2], limited: bool) {
        let groups: [_; LEVELS] = std::array::from_fn(|level| {
            let is_chosen = limited && level > 0;
            let list = if is_chosen {
                self.bind_choice(recorder, views, level)
            } else {
                vec![self.bind_centres(recorder, views, level)]
            };
            (list, self.bind_fit(recorder, views, level))
        });
        recorder.pass(DESCRIPTOR.name, |pass| {
            for (level, (list, fit)) in groups.iter().enumerate() {
                let cells = extent.map(|side| side.div_ceil(LEVEL_STRIDES[level]));
                for (kernel, group) in list {
                    kernel.dispatch(pass, group, cells);
                }
                let arguments = 4 * u64::from(LEVEL_WORDS) * level as u64;
                self.fit.dispatch_indirect(pass, fit, views.levels, arguments);
            }
        });
    }

    fn bind_centres(
        &self,
        recorder: &Recorder<'_>,
        views: &FitViews<'_>,
        level: usize,
    ) -> (&Kernel, BindGroup) {
        let resources =
            [&self.numbers[level], views.coverage, views.moments, views.centre_list, views.levels];
        (&self.centres, self.centres.bind(recorder, &resources.map(Buffer::as_entire_binding)))
    }

    fn bind_choice(
        &self,
        recorder: &Recorder<'_>,
        views: &FitViews<'_>,
        level: usize,
    ) -> Vec<(&Kernel, BindGroup)> {
        let FitViews { moments, centre_list, levels, models, windows, coverage, kept, histogram } = *views;
        let number = &self.numbers[level];
        let gains = [number, coverage, moments, models, kept, histogram].map(Buffer::as_entire_binding);
        let choose =
            [number, kept, histogram, centre_list, levels, windows, coverage].map(Buffer::as_entire_binding);
        vec![
            (&self.gains, self.gains.bind(recorder, &gains)),
            (&self.choose, self.choose.bind(recorder, &choose)),
        ]
    }

    fn bind_fit(&self, recorder: &Recorder<'_>, views: &FitViews<'_>, level: usize) -> BindGroup {
        let FitViews { moments, centre_list, levels, models, windows, coverage, kept, .. } = *views;
        let resources = [&self.numbers[level], moments, centre_list, levels, models, windows, coverage, kept];
        self.fit.bind(recorder, &resources.map(Buffer::as_entire_binding))
    }
}
