//! What a benchmark ran on.

use crate::gpu::Gpu;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// Adapter and computer, as far as they tell.
#[derive(Debug, Clone, Serialize)]
pub struct Machine {
    pub adapter: String,
    pub device_type: String,
    pub backend: String,
    pub driver: String,
    pub driver_info: String,
    /// Fewest and most invocations of a subgroup.
    pub subgroup_sizes: [u32; 2],
    /// Optional wgpu features that the device was opened with.
    pub features: Vec<&'static str>,
    /// Limits of the device that bound the size of a frame and the shape of a pass.
    pub limits: BTreeMap<&'static str, u64>,
    pub os: &'static str,
    pub arch: &'static str,
    pub cpu: Option<String>,
    pub cpu_threads: Option<usize>,
    /// Without optimisation, times of the CPU mean little.
    pub optimised: bool,
}

impl Machine {
    pub fn of(gpu: &Gpu) -> Self {
        let info = gpu.adapter.get_info();
        let limits = gpu.device.limits();
        Self {
            adapter: info.name,
            device_type: format!("{:?}", info.device_type),
            backend: info.backend.to_string(),
            driver: info.driver,
            driver_info: info.driver_info,
            subgroup_sizes: [info.subgroup_min_size, info.subgroup_max_size],
            features: gpu.device.features().iter_names().map(|(name, _)| name).collect(),
            limits: BTreeMap::from([
                ("max_buffer_size", limits.max_buffer_size),
                ("max_compute_workgroup_storage_size", limits.max_compute_workgroup_storage_size.into()),
                ("max_storage_buffer_binding_size", limits.max_storage_buffer_binding_size),
                ("max_texture_dimension_2d", limits.max_texture_dimension_2d.into()),
            ]),
            os: std::env::consts::OS,
            arch: std::env::consts::ARCH,
            cpu: cpu_name(),
            cpu_threads: std::thread::available_parallelism().ok().map(usize::from),
            optimised: !cfg!(debug_assertions),
        }
    }
}

/// A list, for a terminal and as Markdown.
impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { adapter, device_type, backend, driver, driver_info, subgroup_sizes: [min, max], .. } =
            self;
        let features = if self.features.is_empty() { "none".to_owned() } else { self.features.join(", ") };
        let cpu = self.cpu.as_deref().unwrap_or("unknown CPU");
        let threads = self.cpu_threads.map_or(String::new(), |n| format!(", {n} threads"));
        let build = if self.optimised { "" } else { "; a debug build: its CPU times mean little" };
        writeln!(f, "- adapter: {adapter} ({device_type}, {backend}), driver {driver} {driver_info}")?;
        let limits: Vec<_> = self.limits.iter().map(|(name, limit)| format!("{name} {limit}")).collect();
        writeln!(f, "- device: subgroups of {min} to {max}; features: {features}; {}", limits.join(", "))?;
        writeln!(f, "- host: {}, {}, {cpu}{threads}{build}", self.os, self.arch)
    }
}

/// Where the system tells it for nothing.
fn cpu_name() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
