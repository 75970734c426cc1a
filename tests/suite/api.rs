//! What an integrator relies on beside pixels: threads, limits, caches, profilers, formats, memory.

use crate::gpu::{adapter, upload};
use crate::sequence::{denoiser, frame, psnr, read_output, submit, with};
use glam::Vec3;
use quell::{
    Denoiser, DenoiserDescriptor, FrameInputs, HistoryMode, Memory, PASSES, PassProfiler, PassTimestamps,
    Pipelines, Settings,
};
use std::cell::RefCell;
use std::sync::Arc;
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [64, 48];
const EYE: Vec3 = Vec3::new(0.0, 1.4, 1.0);

#[test]
fn denoisers_and_pipelines_may_move_between_threads() {
    fn assert_send_and_sync<T: Send + Sync>() {}
    assert_send_and_sync::<Denoiser>();
    assert_send_and_sync::<Pipelines>();
    assert_send_and_sync::<Settings>();
    assert_send_and_sync::<quell::InputCheck>();
    assert_send_and_sync::<quell::Conventions>();
    assert_send_and_sync::<quell::Statistics>();
    assert_send_and_sync::<Memory>();
    assert_send_and_sync::<quell::CreateError>();
    assert_send_and_sync::<quell::FrameError>();
}

/// Names passes as they come, and wants no timestamps.
#[derive(Debug, Default)]
struct Names(RefCell<Vec<(&'static str, bool)>>);

impl PassProfiler for Names {
    fn begin(&self, pass: &'static str, _: &mut wgpu::CommandEncoder) -> Option<PassTimestamps> {
        self.0.borrow_mut().push((pass, true));
        None
    }

    fn end(&self, pass: &'static str, encoder: &mut wgpu::CommandEncoder) {
        self.0.borrow_mut().push((pass, false));
        // Between passes anything may be recorded.
        encoder.insert_debug_marker(pass);
    }
}

#[test]
fn a_profiler_hears_of_every_pass_in_order() {
    let frame = crate::mirror::mirrored(&frame(SIZE, EYE, EYE, 1), 2);
    let images = frame.upload();
    let inputs = images.inputs(frame.camera, HistoryMode::Continue);
    for inputs in [inputs, inputs.with_specular(None).with_hit_distance(None)] {
        let names = Names::default();
        submit(&mut denoiser(SIZE), &inputs.with_profiler(&names), &Settings::default());
        let expected: Vec<_> = PASSES.iter().flat_map(|&pass| [(pass, true), (pass, false)]).collect();
        assert_eq!(names.0.into_inner(), expected);
    }
    // A debug view of the first of two signals comes before the second, but once as well.
    let (names, shown) = (Names::default(), crate::gpu::blank(SIZE, Format::Rgba16Float));
    let inputs = inputs.with_profiler(&names).with_debug((quell::DebugView::Normal, &shown));
    submit(&mut denoiser(SIZE), &inputs, &Settings::default());
    let mut begun: Vec<_> =
        names.0.borrow().iter().filter_map(|&(pass, begins)| begins.then_some(pass)).collect();
    assert_eq!(begun[5], "debug_view");
    let mut all = PASSES.to_vec();
    all.sort_unstable();
    begun.sort_unstable();
    assert_eq!(begun, all);
}

#[test]
fn a_device_with_the_limits_that_are_asked_for_is_enough() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = adapter(&instance);
    let hd = DenoiserDescriptor::new(1920, 1080);
    assert_eq!(hd.required_limits(), wgpu::Limits::default());
    let wide = DenoiserDescriptor::new(9000, 8);
    let required_limits = wide.required_limits();
    assert_eq!(required_limits.max_texture_dimension_2d, 9000);
    let descriptor = wgpu::DeviceDescriptor {
        required_features: quell::REQUIRED_FEATURES,
        required_limits,
        ..Default::default()
    };
    let (device, _) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    assert!(Denoiser::new(&device, &wide).is_ok());
    assert!(Denoiser::new(&device, &DenoiserDescriptor::new(9001, 8)).is_err());
    let huge = DenoiserDescriptor::new(8192, 8192).required_limits();
    assert!(huge.max_storage_buffer_binding_size > wgpu::Limits::default().max_storage_buffer_binding_size);
}

#[test]
fn pipelines_take_a_cache_and_what_it_held() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = adapter(&instance);
    let descriptor = wgpu::DeviceDescriptor {
        required_features: adapter.features() & quell::OPTIONAL_FEATURES,
        ..Default::default()
    };
    let (device, _) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    if !device.features().contains(wgpu::Features::PIPELINE_CACHE) {
        println!("this adapter has no pipeline cache");
        return;
    }
    let cache = |data: Option<&[u8]>| {
        // SAFETY: the data is none, or what another cache of this driver gave.
        unsafe {
            device.create_pipeline_cache(&wgpu::PipelineCacheDescriptor { label: None, data, fallback: true })
        }
    };
    let size = DenoiserDescriptor::new(SIZE[0], SIZE[1]);
    let first = cache(None);
    let empty = first.get_data().unwrap_or_default().len();
    let pipelines = Pipelines::with_cache(&device, Some(&first)).unwrap();
    assert!(Denoiser::with_pipelines(&device, &size, Arc::new(pipelines)).is_ok());
    let data = first.get_data().unwrap();
    println!("{} bytes, {empty} before", data.len());
    let again = cache(Some(&data));
    let pipelines = Pipelines::with_cache(&device, Some(&again)).unwrap();
    assert!(Denoiser::with_pipelines(&device, &size, Arc::new(pipelines)).is_ok());
}

#[test]
fn memory_is_summed_by_kind() {
    let quell = denoiser(SIZE);
    let memory = quell.memory();
    let kinds = [&memory.history, &memory.models, &memory.scratch].map(Memory::sum);
    assert!(kinds.iter().all(|&bytes| bytes > 0), "{kinds:?}");
    assert_eq!(memory.total(), kinds.iter().sum());
    // The temporal mean, its noise and the surfaces of two frames.
    assert_eq!(kinds[0], u64::from(SIZE[0] * SIZE[1]) * (8 + 4 + 8 + 8));
    assert!(format!("{quell:?}").len() < 200, "{quell:?}");
}

/// The output with some of a frame's images in other formats.
fn output_with(
    change: impl for<'a> Fn(FrameInputs<'a>, &'a [wgpu::TextureView]) -> FrameInputs<'a>,
    others: &[wgpu::TextureView],
) -> Vec<[f32; 3]> {
    let frame = frame(SIZE, EYE, EYE, 5);
    let images = frame.upload();
    let inputs = change(images.inputs(frame.camera, HistoryMode::Continue), others);
    submit(&mut denoiser(SIZE), &inputs, &Settings::default());
    read_output(&images.output)
}

#[test]
fn formats_of_other_renderers_work() {
    let plain = output_with(|inputs, _| inputs, &[]);
    let frame = frame(SIZE, EYE, EYE, 5);
    let bytes = |texels: &[[f32; 4]], order: [usize; 4]| -> Vec<[u8; 4]> {
        texels.iter().map(|t| order.map(|c| (t[c].clamp(0.0, 1.0) * 255.0).round() as u8)).collect()
    };
    let bgra = upload(SIZE, Format::Bgra8Unorm, &bytes(&frame.albedo, [2, 1, 0, 3]));
    let packed: Vec<u32> = (frame.albedo.iter())
        .map(|t| (0..3).map(|c| ((t[c] * 1023.0).round() as u32) << (10 * c)).sum::<u32>() | 3 << 30)
        .collect();
    let ten_bits = upload(SIZE, Format::Rgb10a2Unorm, &packed);
    for albedo in [bgra, ten_bits] {
        let format = albedo.texture().format();
        let found = output_with(|inputs, others| with(inputs, |i| i.albedo = &others[0]), &[albedo]);
        let psnr = psnr(&found, &plain);
        assert!(psnr > 45.0, "{format:?}: {psnr:.1} dB");
    }
    // A roughness of its own stands before that of the normals, in any of its formats.
    let rough = (SIZE[0] * SIZE[1]) as usize;
    let mut normals = frame.normal.clone();
    normals.iter_mut().for_each(|normal| normal[3] = 0.1);
    for (format, texels) in
        [(Format::R8Unorm, vec![255u8; rough]), (Format::Rgba8Unorm, vec![255u8; 4 * rough])]
    {
        let others = [upload(SIZE, Format::Rgba32Float, &normals), upload(SIZE, format, &texels)];
        let found = output_with(
            |inputs, others| with(inputs, |i| i.normal_roughness = &others[0]).with_roughness(&others[1]),
            &others,
        );
        assert_eq!(found, plain, "{format:?}");
    }
    // Exponents of 5 bits, of which 15 is 1; mantissas of 0.
    let ones = upload(SIZE, Format::Rg11b10Ufloat, &vec![15u32 << 6 | 15 << 17 | 15 << 27; rough]);
    let wide = upload(SIZE, Format::Rgba32Float, &vec![[1.0f32; 4]; rough]);
    let [packed, plain] = [ones, wide]
        .map(|radiance| output_with(|inputs, others| with(inputs, |i| i.radiance = &others[0]), &[radiance]));
    assert_eq!(packed, plain);
    // Ids of 16 bits.
    let short: Vec<u16> = frame.id.iter().map(|&id| id as u16).collect();
    let ids = upload(SIZE, Format::R16Uint, &short);
    let found = output_with(|inputs, others| inputs.with_surface_id(&others[0]), &[ids]);
    assert_eq!(found, output_with(|inputs, _| inputs, &[]));
}

/// Presets differ from the default in what they say.
#[test]
fn presets_are_valid_and_differ() {
    let frame = frame(SIZE, EYE, EYE, 5);
    let images = frame.upload();
    let inputs = images.inputs(frame.camera, HistoryMode::Continue);
    let presets = [Settings::default(), Settings::responsive(), Settings::still(), Settings::fast()];
    for (i, preset) in presets.iter().enumerate() {
        assert!(presets[i + 1..].iter().all(|other| other != preset));
        submit(&mut denoiser(SIZE), &inputs, preset);
    }
}

/// Pipelines of a device that is gone are of no use on the next.
#[test]
fn pipelines_of_another_device_are_refused() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = adapter(&instance);
    let device = || pollster::block_on(adapter.request_device(&Default::default())).unwrap().0;
    let (gone, new) = (device(), device());
    let size = DenoiserDescriptor::new(8, 8);
    let pipelines = Denoiser::new(&gone, &size).unwrap().pipelines();
    assert!(Denoiser::with_pipelines(&gone, &size, pipelines.clone()).is_ok());
    let refused = Denoiser::with_pipelines(&new, &size, pipelines).unwrap_err();
    assert_eq!(refused, quell::CreateError::OtherDevice);
}

/// Alpha that holds nothing is no mirror.
#[test]
fn normals_may_come_without_roughness() {
    let plain = output_with(|inputs, _| inputs, &[]);
    let frame = frame(SIZE, EYE, EYE, 5);
    let normals: Vec<[f32; 4]> = frame.normal.iter().map(|&[x, y, z, _]| [x, y, z, 0.0]).collect();
    let images = frame.upload();
    let normals = upload(SIZE, Format::Rgba32Float, &normals);
    let inputs = images.inputs(frame.camera, HistoryMode::Continue);
    let inputs = with(inputs, |i| i.normal_roughness = &normals);
    let conventions = quell::Conventions::default().with_normal_has_roughness(false);
    submit(&mut denoiser(SIZE), &inputs, &Settings::default().with_conventions(conventions));
    assert_eq!(read_output(&images.output), plain);
}
