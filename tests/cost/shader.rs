//! What a shader's intermediate representation tells: workgroup memory, what is read and written, loads of texels.

use quell::gpu::{KernelDescriptor, assemble};
use std::collections::HashSet;
use wgpu::naga::{self, AddressSpace, Expression, Function, Handle, Statement, valid::GlobalUse};

/// A kernel as the library compiles it.
pub struct Shader {
    pub descriptor: &'static KernelDescriptor,
    pub module: naga::Module,
    pub info: naga::valid::ModuleInfo,
}

impl Shader {
    pub fn all() -> Vec<Self> {
        quell::passes::ALL.into_iter().map(Self::new).collect()
    }

    fn new(descriptor: &'static KernelDescriptor) -> Self {
        let source = assemble(descriptor.source);
        let module = naga::front::wgsl::parse_str(&source)
            .unwrap_or_else(|error| panic!("{}: {}", descriptor.name, error.emit_to_string(&source)));
        // What a shader may ask of a device is the suite's concern.
        let capabilities = naga::valid::Capabilities::all();
        let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
            .validate(&module)
            .unwrap_or_else(|error| panic!("{}: {}", descriptor.name, error.emit_to_string(&source)));
        assert_eq!(module.entry_points.len(), 1, "{}: entry points", descriptor.name);
        Self { descriptor, module, info }
    }

    pub fn name(&self) -> &'static str {
        self.descriptor.name
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

    /// Whether the kernel reads and whether it writes a binding; an atomic operation does both.
    pub fn access(&self, binding: &str) -> (bool, bool) {
        let mut globals = self.module.global_variables.iter();
        let found = globals.find(|(_, variable)| variable.name.as_deref() == Some(binding));
        let (handle, _) = found.unwrap_or_else(|| panic!("{}: no binding {binding}", self.name()));
        let uses = self.uses(handle);
        (uses.contains(GlobalUse::READ), uses.contains(GlobalUse::WRITE))
    }

    /// By the entry point and all that it calls.
    fn uses(&self, global: Handle<naga::GlobalVariable>) -> GlobalUse {
        self.info.get_entry_point(0)[global]
    }

    /// Places in the code, not executions, that load a texel.
    pub fn load_sites(&self) -> usize {
        let entry = &self.module.entry_points[0].function;
        let (mut called, mut waiting) = (HashSet::new(), vec![entry]);
        let mut sites = 0;
        while let Some(function) = waiting.pop() {
            sites += loads(function);
            calls(&function.body, &mut |callee| {
                if called.insert(callee) {
                    waiting.push(&self.module.functions[callee]);
                }
            });
        }
        sites
    }
}

fn loads(function: &Function) -> usize {
    let expressions = function.expressions.iter();
    expressions.filter(|(_, expression)| matches!(expression, Expression::ImageLoad { .. })).count()
}

fn calls(block: &naga::Block, found: &mut impl FnMut(Handle<Function>)) {
    for statement in block {
        match statement {
            Statement::Call { function, .. } => found(*function),
            Statement::Block(inner) => calls(inner, found),
            Statement::If { accept, reject, .. } => {
                calls(accept, found);
                calls(reject, found);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| calls(&case.body, found)),
            Statement::Loop { body, continuing, .. } => {
                calls(body, found);
                calls(continuing, found);
            }
            _ => {}
        }
    }
}
