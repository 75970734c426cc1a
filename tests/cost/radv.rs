//! Compiles every kernel by RADV, Mesa's driver for AMD GPUs, which needs no GPU for it, and asks what became of it.
//!
//! Runs in a child process: the driver reads its environment when it is loaded.

use crate::shader::Shader;
use ash::vk;
use std::ffi::{CStr, CString};
use wgpu::naga::back::spv;
use wgpu::naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use wgpu::naga::{AddressSpace, GlobalVariable, ImageClass, ShaderStage, TypeInner};

/// A line `driver`, then one `kernel, statistic, value` for each; separated by tabs.
pub fn report() -> Result<String, Box<dyn std::error::Error>> {
    let compiler = Compiler::new()?;
    let mut lines = format!("driver\t{}\n", compiler.driver);
    for shader in Shader::all() {
        for (statistic, value) in compiler.statistics(&shader)? {
            lines += &format!("{}\t{statistic}\t{value}\n", shader.name());
        }
    }
    Ok(lines)
}

/// Lives as long as the child process, whose end frees it all.
struct Compiler {
    _entry: ash::Entry,
    device: ash::Device,
    executables: ash::khr::pipeline_executable_properties::Device,
    driver: String,
}

impl Compiler {
    fn new() -> Result<Self, Box<dyn std::error::Error>> {
        // SAFETY: handles are used while the instance lives, and every chained structure outlives its call.
        unsafe {
            let entry = ash::Entry::load()?;
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let create = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&create, None)?;
            let gpu = *instance.enumerate_physical_devices()?.first().ok_or("RADV shows no device")?;

            let mut driver = vk::PhysicalDeviceDriverProperties::default();
            let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
            instance.get_physical_device_properties2(gpu, &mut properties);
            if driver.driver_id != vk::DriverId::MESA_RADV {
                return Err("the driver is not RADV".into());
            }
            let driver = driver.driver_info_as_c_str()?.to_str()?.to_owned();

            // The features that wgpu asks for, as far as they change code: bounds of images and buffers are the driver's.
            let mut robustness = vk::PhysicalDeviceRobustness2FeaturesEXT::default()
                .robust_buffer_access2(true)
                .robust_image_access2(true);
            let mut executable = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
                .pipeline_executable_info(true);
            let mut vulkan13 = vk::PhysicalDeviceVulkan13Features::default()
                .robust_image_access(true)
                .shader_zero_initialize_workgroup_memory(true);
            let features = vk::PhysicalDeviceFeatures::default()
                .robust_buffer_access(true)
                .shader_storage_image_write_without_format(true)
                .shader_storage_image_extended_formats(true);
            let extensions = [ash::khr::pipeline_executable_properties::NAME, ash::ext::robustness2::NAME]
                .map(CStr::as_ptr);
            let queues =
                [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
            let create = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_extension_names(&extensions)
                .enabled_features(&features)
                .push_next(&mut robustness)
                .push_next(&mut executable)
                .push_next(&mut vulkan13);
            let device = instance.create_device(gpu, &create, None)?;
            let executables = ash::khr::pipeline_executable_properties::Device::new(&instance, &device);
            Ok(Self { _entry: entry, device, executables, driver })
        }
    }

    fn statistics(&self, shader: &Shader) -> Result<Vec<(String, u64)>, Box<dyn std::error::Error>> {
        let code = spirv(shader)?;
        let bindings: Vec<_> = shader
            .module
            .global_variables
            .iter()
            .filter_map(|(_, variable)| {
                let kind = descriptor_type(variable, &shader.module.types[variable.ty].inner)?;
                Some(
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(variable.binding?.binding)
                        .descriptor_type(kind)
                        .descriptor_count(1)
                        .stage_flags(vk::ShaderStageFlags::COMPUTE),
                )
            })
            .collect();
        let name = CString::new(shader.descriptor.name)?;
        // SAFETY: as in `new`.
        unsafe {
            let set = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            let sets = [self.device.create_descriptor_set_layout(&set, None)?];
            let layout = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            let module =
                self.device.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(&code), None)?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(&name);
            let create = vk::ComputePipelineCreateInfo::default()
                .flags(vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR)
                .layout(self.device.create_pipeline_layout(&layout, None)?)
                .stage(stage);
            let cache = vk::PipelineCache::null();
            let pipelines = self.device.create_compute_pipelines(cache, &[create], None);
            let pipeline = pipelines.map_err(|(_, error)| error)?[0];
            let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
            let subgroup = self.executables.get_pipeline_executable_properties(&info)?[0].subgroup_size;
            let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline);
            let mut found = vec![("Wave size".to_owned(), u64::from(subgroup))];
            for statistic in self.executables.get_pipeline_executable_statistics(&info)? {
                if statistic.format == vk::PipelineExecutableStatisticFormatKHR::UINT64 {
                    found.push((statistic.name_as_c_str()?.to_str()?.to_owned(), statistic.value.u64));
                }
            }
            Ok(found)
        }
    }
}

fn descriptor_type(variable: &GlobalVariable, inner: &TypeInner) -> Option<vk::DescriptorType> {
    Some(match (variable.space, inner) {
        (AddressSpace::Uniform, _) => vk::DescriptorType::UNIFORM_BUFFER,
        (AddressSpace::Storage { .. }, _) => vk::DescriptorType::STORAGE_BUFFER,
        (_, TypeInner::Image { class: ImageClass::Storage { .. }, .. }) => vk::DescriptorType::STORAGE_IMAGE,
        (_, TypeInner::Image { .. }) => vk::DescriptorType::SAMPLED_IMAGE,
        _ => return None,
    })
}

/// As wgpu 30 writes it for a device with these features: checked indices, bounded loops (unless a module is created as
/// trusted, which none is), zeroed workgroup memory.
fn spirv(shader: &Shader) -> Result<Vec<u32>, spv::Error> {
    let options = spv::Options {
        lang_version: (1, 6),
        flags: spv::WriterFlags::empty(),
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: BoundsCheckPolicy::Unchecked,
            image_load: BoundsCheckPolicy::Unchecked,
            binding_array: BoundsCheckPolicy::Unchecked,
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::Native,
        force_loop_bounding: true,
        ..spv::Options::default()
    };
    let entry = spv::PipelineOptions {
        shader_stage: ShaderStage::Compute,
        entry_point: shader.descriptor.name.into(),
    };
    spv::write_vec(&shader.module, &shader.info, &options, Some(&entry))
}
