//! Devices that fail: lost ones, and ones without memory.

use glam::{Mat4, camera::rh::proj::directx};
use quell::{
    Camera, CreateError, Denoiser, DenoiserDescriptor, DeviceError, FrameError, FrameInputs, FrameOutputs,
    RequiredInputs, Settings,
};
use wgpu::TextureFormat as Format;

/// On the CPU adapter first.
pub fn device(instance: &wgpu::Instance) -> (wgpu::Device, wgpu::Queue) {
    pollster::block_on(crate::gpu::adapter(instance).request_device(&Default::default())).unwrap()
}

pub struct Images {
    colours: [wgpu::TextureView; 4],
    depth: wgpu::TextureView,
    output: wgpu::TextureView,
}

impl Images {
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let image = |format| quell::gpu::image(device, "test", size, format);
        Self {
            colours: [Format::Rgba16Float; 4].map(image),
            depth: image(Format::R32Float),
            output: image(Format::Rgba16Float),
        }
    }

    pub fn encode(
        &self,
        quell: &mut Denoiser,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<FrameOutputs, FrameError> {
        let [radiance, albedo, normal_roughness, motion] = &self.colours;
        let camera = Camera::new(Mat4::IDENTITY, directx::perspective(1.0, 1.5, 0.1, 100.0));
        let (depth, output) = (&self.depth, &self.output);
        let inputs = FrameInputs::new(RequiredInputs {
            radiance,
            albedo,
            normal_roughness,
            depth,
            motion,
            output,
            camera,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let outputs = quell.encode(device, queue, &mut encoder, &inputs, &Settings::default())?;
        queue.submit([encoder.finish()]);
        Ok(outputs)
    }
}

const SIZE: [u32; 2] = [40, 24];

#[test]
fn a_lost_device_is_an_error_and_a_new_one_works() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let (device, queue) = self::device(&instance);
    let descriptor = DenoiserDescriptor::new(SIZE[0], SIZE[1]);
    let mut quell = Denoiser::new(&device, &descriptor).unwrap();
    let images = Images::new(&device, SIZE);
    images.encode(&mut quell, &device, &queue).unwrap();
    device.destroy();
    for _ in 0..3 {
        assert_eq!(images.encode(&mut quell, &device, &queue), Err(FrameError::Device(DeviceError::Lost)));
    }
    let _ = quell.statistics();
    let refused = Denoiser::new(&device, &descriptor).unwrap_err();
    assert_eq!(refused, CreateError::Device(DeviceError::Lost));
    assert!(refused.to_string().contains("create a new one"), "{refused}");
    assert!(quell.resize(&device, &DenoiserDescriptor::new(8, 8)).is_err());

    let (device, queue) = self::device(&instance);
    let mut quell = Denoiser::new(&device, &descriptor).unwrap();
    assert!(Images::new(&device, SIZE).encode(&mut quell, &device, &queue).unwrap().restarted);
}

/// More than all small allocations take, less than any image or the moments of [`LARGE`] pixels a side.
const LEFT_KB: u64 = 60_000;
const LARGE: u32 = 4096;

/// Drivers on the CPU run out of memory where their process does: another process, which leaves itself little.
#[test]
#[cfg(target_os = "linux")]
fn a_device_without_memory_is_an_error_and_the_denoiser_stays() {
    let own = std::env::current_exe().unwrap();
    let mut child = std::process::Command::new("timeout");
    child.arg("120").arg(own).args(["--ignored", "--exact", "lost::with_little_memory"]);
    let output = child.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && text.contains("1 passed"), "{text}");
}

#[test]
#[ignore = "run by another test, in a process of its own"]
fn with_little_memory() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let (device, queue) = self::device(&instance);
    let mut quell = Denoiser::new(&device, &DenoiserDescriptor::new(SIZE[0], SIZE[1])).unwrap();
    let images = Images::new(&device, SIZE);
    images.encode(&mut quell, &device, &queue).unwrap();
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let held = quell.memory();
    let most = (crate::status_kb("VmSize:") + LEFT_KB) * 1024;
    let limit = ["--pid", &std::process::id().to_string(), &format!("--as={most}")];
    assert!(std::process::Command::new("prlimit").args(limit).status().unwrap().success());
    let refused = quell.resize(&device, &DenoiserDescriptor::new(LARGE, LARGE)).unwrap_err();
    assert_eq!(refused, CreateError::Device(DeviceError::OutOfMemory));
    assert!(refused.to_string().contains("out of memory"), "{refused}");
    // As it was, history included.
    assert_eq!(quell.memory(), held);
    assert!(!images.encode(&mut quell, &device, &queue).unwrap().restarted);
}
