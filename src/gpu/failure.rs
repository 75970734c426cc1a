//! Errors of the device, caught where something is created on it.

use crate::DeviceError;
use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};
use wgpu::ErrorFilter;

/// Runs `create`; tells if the device ran out of memory or failed meanwhile. Only where errors are known at once, which is
/// everywhere but in browsers: there they reach the device's uncaptured error handler, as any other.
pub fn catch<T>(device: &wgpu::Device, create: impl FnOnce() -> T) -> Result<T, DeviceError> {
    if cfg!(target_arch = "wasm32") {
        return Ok(create());
    }
    // What uses a resource that there was no memory for is invalid in turn: of several errors the causes come first.
    let validation = device.push_error_scope(ErrorFilter::Validation);
    let internal = device.push_error_scope(ErrorFilter::Internal);
    let memory = device.push_error_scope(ErrorFilter::OutOfMemory);
    let created = create();
    let errors = [known(memory.pop()), known(internal.pop()), known(validation.pop())];
    match errors.into_iter().flatten().next() {
        None => Ok(created),
        Some(wgpu::Error::OutOfMemory { .. }) => Err(DeviceError::OutOfMemory),
        Some(error) => Err(DeviceError::Failed { description: error.to_string() }),
    }
}

/// Refuses a device that is lost, on which creating anything silently comes to nothing.
pub fn check_alive(device: &wgpu::Device) -> Result<(), DeviceError> {
    uniform_buffer(device, "quell probe", &[0; 16]).map(drop)
}

/// A uniform buffer with these bytes, created anew: several frames may be recorded before one submission.
pub fn uniform_buffer(device: &wgpu::Device, label: &str, bytes: &[u8]) -> Result<wgpu::Buffer, DeviceError> {
    let buffer = catch(device, || {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.len() as u64,
            usage: wgpu::BufferUsages::UNIFORM,
            mapped_at_creation: true,
        })
    })?;
    // Of a device that is lost nothing can be mapped; nobody else would say so.
    let mut range = buffer.get_mapped_range_mut(..).map_err(|_| DeviceError::Lost)?;
    range.copy_from_slice(bytes);
    drop(range);
    buffer.unmap();
    Ok(buffer)
}

/// What a future comes to that is ready.
fn known<T>(future: impl Future<Output = Option<T>>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(error) => error,
        Poll::Pending => None,
    }
}
