//! Places centres level by level and fits a model at each. See `shaders/centres.wgsl` and `shaders/fit.wgsl`.

use super::centres;
use crate::gpu::{Kernel, KernelDescriptor, Kind, Recorder};
use crate::layout::{LEVEL_STRIDES, LEVEL_WORDS, LEVELS};
use wgpu::Buffer;
use wgpu::util::DeviceExt;

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
    ],
    workgroup: [64, 1],
    covers: [1, 1],
};

/// What the pass reads and writes; named as in the WGSL. `windows`, `coverage` and `levels` are 0 before it.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct FitViews<'a> {
    pub moments: &'a Buffer,
    pub centre_list: &'a Buffer,
    pub levels: &'a Buffer,
    pub models: &'a Buffer,
    pub windows: &'a Buffer,
    pub coverage: &'a Buffer,
}

/// The pass: for each level, a dispatch that lists centres and one that fits their models.
#[derive(Debug)]
pub struct Fit {
    centres: Kernel,
    fit: Kernel,
    /// The number of each level.
    numbers: [Buffer; LEVELS],
}

impl Fit {
    /// Compiles the pass.
    pub fn new(device: &wgpu::Device) -> Self {
        let number = |level: usize| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("quell level"),
                contents: bytemuck::cast_slice(&[level as u32, 0, 0, 0]),
                usage: wgpu::BufferUsages::UNIFORM,
            })
        };
        Self {
            centres: Kernel::new(device, &centres::DESCRIPTOR),
            fit: Kernel::new(device, &DESCRIPTOR),
            numbers: std::array::from_fn(number),
        }
    }

    /// Records the pass over `extent` tiles.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &FitViews<'_>, extent: [u32; 2]) {
        let groups = self.numbers.each_ref().map(|number| {
            let centres = [
                number.as_entire_binding(),
                views.coverage.as_entire_binding(),
                views.moments.as_entire_binding(),
                views.centre_list.as_entire_binding(),
                views.levels.as_entire_binding(),
            ];
            let fit = [
                number.as_entire_binding(),
                views.moments.as_entire_binding(),
                views.centre_list.as_entire_binding(),
                views.levels.as_entire_binding(),
                views.models.as_entire_binding(),
                views.windows.as_entire_binding(),
                views.coverage.as_entire_binding(),
            ];
            (self.centres.bind(recorder, &centres), self.fit.bind(recorder, &fit))
        });
        let mut pass = recorder.begin_pass(DESCRIPTOR.name);
        for (level, (centres, fit)) in groups.iter().enumerate() {
            let cells = extent.map(|side| side.div_ceil(LEVEL_STRIDES[level]));
            self.centres.dispatch(&mut pass, centres, cells);
            let arguments = 4 * u64::from(LEVEL_WORDS) * level as u64;
            self.fit.dispatch_indirect(&mut pass, fit, views.levels, arguments);
        }
    }
}
