//! Other methods, to compare the denoiser with, each written from its paper over the same images, and antialiasing for all. They get
//! combined radiance, as their papers have it, also of frames whose radiance is split.

mod accumulate;
mod antialias;
mod bmfr;
mod frame;
pub mod shaders;
mod svgf;

pub use accumulate::Accumulate;
pub use antialias::Antialias;
pub use bmfr::Bmfr;
pub use frame::PeerFrame;
pub use svgf::Svgf;

use quell::Allocation;

/// The uniform `frame` at binding 0 and images after it.
fn views<'a>(
    frame: wgpu::BindingResource<'a>,
    views: &[&'a wgpu::TextureView],
) -> Vec<wgpu::BindingResource<'a>> {
    std::iter::once(frame).chain(views.iter().map(|view| wgpu::BindingResource::TextureView(view))).collect()
}

/// Names of images, one of each, and how many there are.
fn allocations(images: &[(&'static str, &wgpu::TextureView, u64)]) -> Vec<Allocation> {
    let allocation = |&(name, view, count)| {
        let one = Allocation::of_image(name, view);
        Allocation { bytes: count * one.bytes, ..one }
    };
    images.iter().map(allocation).collect()
}
