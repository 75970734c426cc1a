//! Fetches each pixel's history. See `shaders/reproject.wgsl`.

use crate::gpu::{Compiler, Constants, Kernel, KernelDescriptor, Kind, Recorder};
use wgpu::{BindingResource, Buffer, TextureFormat, TextureView};

/// What the pass is made of.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "reproject",
    source: include_str!("../../shaders/reproject.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("radiance", Kind::Texture),
        ("albedo", Kind::Texture),
        ("normal_roughness", Kind::Texture),
        ("roughness", Kind::Texture),
        ("depth", Kind::Texture),
        ("motion", Kind::Texture),
        ("surface_id", Kind::TextureUint),
        ("emission", Kind::Texture),
        ("sample_count", Kind::TextureUint),
        ("hit_distance", Kind::Texture),
        ("previous_guide", Kind::TextureUint),
        ("history", Kind::Texture),
        ("noise", Kind::TextureUint),
        ("guide", Kind::Storage(TextureFormat::Rg32Uint)),
        ("signal", Kind::Storage(TextureFormat::R32Uint)),
        ("reprojected", Kind::Storage(TextureFormat::Rg32Uint)),
        ("reprojected_noise", Kind::Storage(TextureFormat::R32Uint)),
        ("moments", Kind::BufferMut),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};

/// What the pass reads and writes; named as in the WGSL.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct ReprojectViews<'a> {
    pub radiance: &'a TextureView,
    pub albedo: &'a TextureView,
    pub normal_roughness: &'a TextureView,
    pub roughness: &'a TextureView,
    pub depth: &'a TextureView,
    pub motion: &'a TextureView,
    pub surface_id: &'a TextureView,
    pub emission: &'a TextureView,
    pub sample_count: &'a TextureView,
    pub hit_distance: &'a TextureView,
    pub previous_guide: &'a TextureView,
    pub history: &'a TextureView,
    pub noise: &'a TextureView,
    pub guide: &'a TextureView,
    pub signal: &'a TextureView,
    pub reprojected: &'a TextureView,
    pub reprojected_noise: &'a TextureView,
    pub moments: &'a Buffer,
}

/// The pass.
#[derive(Debug, Clone)]
pub struct Reproject(Kernel);

impl Reproject {
    /// Compiles the pass: as it is, for the specular signal, for hit distances, for other conventions.
    pub fn new<'a>(compiler: impl Into<Compiler<'a>>, constants: &Constants) -> Self {
        Self(Kernel::with(compiler, &DESCRIPTOR, constants))
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &ReprojectViews<'_>, extent: [u32; 2]) {
        let resources = [
            BindingResource::TextureView(views.radiance),
            BindingResource::TextureView(views.albedo),
            BindingResource::TextureView(views.normal_roughness),
            BindingResource::TextureView(views.roughness),
            BindingResource::TextureView(views.depth),
            BindingResource::TextureView(views.motion),
            BindingResource::TextureView(views.surface_id),
            BindingResource::TextureView(views.emission),
            BindingResource::TextureView(views.sample_count),
            BindingResource::TextureView(views.hit_distance),
            BindingResource::TextureView(views.previous_guide),
            BindingResource::TextureView(views.history),
            BindingResource::TextureView(views.noise),
            BindingResource::TextureView(views.guide),
            BindingResource::TextureView(views.signal),
            BindingResource::TextureView(views.reprojected),
            BindingResource::TextureView(views.reprojected_noise),
            views.moments.as_entire_binding(),
        ];
        self.0.record(recorder, &resources, extent);
    }
}
