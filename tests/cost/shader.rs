//! What a shader's intermediate representation tells: workgroup memory, what is read and what is written.

use quell::gpu::{Constants, KernelDescriptor, REFLECTIONS, SPECULAR, assemble};
use quell::passes::reproject;
use wgpu::naga::{
    self, AddressSpace, Expression, GlobalVariable, Handle, Literal, TypeInner, valid::GlobalUse,
};

/// What names in the table begin with where the kernel was compiled for the specular signal, or for hit distances.
pub const SPECULAR_PREFIX: &str = "specular ";
pub const REFLECTIONS_PREFIX: &str = "reflections ";

/// A kernel as the library compiles it.
pub struct Shader {
    /// As in the table.
    pub name: String,
    pub descriptor: &'static KernelDescriptor,
    pub module: naga::Module,
    pub info: naga::valid::ModuleInfo,
}

impl Shader {
    pub fn all() -> Vec<Self> {
        let variant = |prefix, constants| {
            move |descriptor: &'static KernelDescriptor| {
                Self::compile(descriptor, format!("{prefix}{}", descriptor.name), constants)
            }
        };
        let specular = quell::passes::SPECULAR_KERNELS.into_iter().map(variant(SPECULAR_PREFIX, SPECULAR));
        let reflections = [&reproject::DESCRIPTOR].into_iter().map(variant(REFLECTIONS_PREFIX, REFLECTIONS));
        quell::passes::ALL.into_iter().map(Self::new).chain(specular).chain(reflections).collect()
    }

    pub fn new(descriptor: &'static KernelDescriptor) -> Self {
        Self::compile(descriptor, descriptor.name.to_owned(), &[])
    }

    fn compile(descriptor: &'static KernelDescriptor, name: String, constants: &Constants) -> Self {
        let source = assemble(descriptor.source);
        let module = naga::front::wgsl::parse_str(&source)
            .unwrap_or_else(|error| panic!("{}: {}", descriptor.name, error.emit_to_string(&source)));
        // What a shader may ask of a device is the suite's concern.
        let capabilities = naga::valid::Capabilities::all();
        let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
            .validate(&module)
            .unwrap_or_else(|error| panic!("{}: {}", descriptor.name, error.emit_to_string(&source)));
        assert_eq!(module.entry_points.len(), 1, "{}: entry points", descriptor.name);
        let constants = constants.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        let entry = Some((naga::ShaderStage::Compute, descriptor.name));
        let (module, info) =
            naga::back::pipeline_constants::process_overrides(&module, &info, entry, &constants)
                .unwrap_or_else(|error| panic!("{name}: {error}"));
        let (module, info) = (module.into_owned(), info.into_owned());
        Self { name, descriptor, module, info }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn invocations(&self) -> u32 {
        self.descriptor.workgroup.iter().product()
    }

    pub fn workgroup_bytes(&self) -> u32 {
        let mut layouter = naga::proc::Layouter::default();
        layouter.update(self.module.to_ctx()).unwrap();
        let shared = self.module.global_variables.iter();
        let used = shared.filter(|&(handle, variable)| {
            variable.space == AddressSpace::WorkGroup && !self.uses(handle).is_empty()
        });
        used.map(|(_, variable)| layouter[variable.ty].to_stride()).sum()
    }

    /// A constant of the shader.
    pub fn constant(&self, name: &str) -> Option<u32> {
        let mut constants = self.module.constants.iter();
        let (_, constant) = constants.find(|(_, constant)| constant.name.as_deref() == Some(name))?;
        match self.module.global_expressions[constant.init] {
            Expression::Literal(Literal::U32(value)) => Some(value),
            Expression::Literal(Literal::I32(value)) => value.try_into().ok(),
            Expression::Literal(Literal::AbstractInt(value)) => value.try_into().ok(),
            _ => None,
        }
    }

    /// Of a buffer that is an array.
    pub fn element_bytes(&self, binding: &str) -> u32 {
        let (_, variable) = self.global(binding);
        match self.module.types[variable.ty].inner {
            TypeInner::Array { stride, .. } => stride,
            _ => panic!("{}: {binding} is no array", self.name()),
        }
    }

    /// Whether the kernel reads and whether it writes a binding; an atomic operation does both.
    pub fn access(&self, binding: &str) -> (bool, bool) {
        let (handle, _) = self.global(binding);
        let uses = self.uses(handle);
        (uses.contains(GlobalUse::READ), uses.contains(GlobalUse::WRITE))
    }

    fn global(&self, binding: &str) -> (Handle<GlobalVariable>, &GlobalVariable) {
        let mut globals = self.module.global_variables.iter();
        let found = globals.find(|(_, variable)| variable.name.as_deref() == Some(binding));
        found.unwrap_or_else(|| panic!("{}: no binding {binding}", self.name()))
    }

    /// By the entry point and all that it calls.
    fn uses(&self, global: Handle<GlobalVariable>) -> GlobalUse {
        self.info.get_entry_point(0)[global]
    }
}
