//! One call of a function, and the integers that are known in it.

use super::lanes::{Lanes, Mask};
use std::collections::HashMap;
use wgpu::naga::{
    BinaryOperator, Expression, Function, Handle, LocalVariable, Module, TypeInner, UnaryOperator,
    valid::FunctionInfo,
};

/// Members of the frame's uniforms that are taken as known, with their defaults.
const UNIFORMS: [(&str, i64); 2] = [("least_window", 1), ("widest_window", 3)];

/// A call.
pub struct Call<'a> {
    pub module: &'a Module,
    pub function: &'a Function,
    pub info: &'a FunctionInfo,
    pub arguments: Vec<Lanes>,
    pub locals: HashMap<Handle<LocalVariable>, Lanes>,
    pub values: HashMap<Handle<Expression>, Lanes>,
    /// Invocations that left the loop, its round, the function.
    pub broke: Mask,
    pub continued: Mask,
    pub returned: Mask,
    /// Whether data may have ended the loop.
    pub may_end: bool,
    pub result: Lanes,
}

impl<'a> Call<'a> {
    pub fn new(
        module: &'a Module,
        function: &'a Function,
        info: &'a FunctionInfo,
        arguments: Vec<Lanes>,
    ) -> Self {
        let mut call = Self {
            module,
            function,
            info,
            arguments,
            locals: HashMap::new(),
            values: HashMap::new(),
            broke: 0,
            continued: 0,
            returned: 0,
            may_end: false,
            result: Lanes::UNKNOWN,
        };
        for (variable, local) in function.local_variables.iter() {
            if let Some(init) = local.init {
                let value = call.value(init);
                call.locals.insert(variable, value);
            }
        }
        call
    }

    /// Of a value, or of what a pointer points to.
    pub fn scalars(&self, expression: Handle<Expression>) -> u64 {
        let types = &self.module.types;
        let mut inner = self.info[expression].ty.inner_with(types);
        if let TypeInner::Pointer { base, .. } = *inner {
            inner = &types[base].inner;
        }
        match *inner {
            TypeInner::Vector { size, .. } | TypeInner::ValuePointer { size: Some(size), .. } => size as u64,
            TypeInner::Matrix { columns, rows, .. } => columns as u64 * rows as u64,
            _ => 1,
        }
    }

    /// As it was when the expression was last emitted, which for a load matters.
    pub fn value(&self, expression: Handle<Expression>) -> Lanes {
        self.values.get(&expression).copied().unwrap_or_else(|| self.evaluate(expression))
    }

    pub fn evaluate(&self, expression: Handle<Expression>) -> Lanes {
        let module = self.module;
        match self.function.expressions[expression] {
            Expression::Literal(literal) => Lanes::literal(literal),
            Expression::Constant(constant) => {
                match module.global_expressions[module.constants[constant].init] {
                    Expression::Literal(literal) => Lanes::literal(literal),
                    _ => Lanes::UNKNOWN,
                }
            }
            Expression::ZeroValue(_) => Lanes::all(0),
            Expression::FunctionArgument(index) => self.arguments[index as usize],
            Expression::Load { pointer } => self.load(pointer),
            Expression::Access { base, index } => self.element(base, &self.value(index)),
            Expression::AccessIndex { base, index } => self.element(base, &Lanes::all(index.into())),
            Expression::Binary { op, left, right } => {
                Lanes::binary(op, &self.value(left), &self.value(right))
            }
            Expression::Unary { op: UnaryOperator::LogicalNot, expr } => {
                Lanes::binary(BinaryOperator::Equal, &self.value(expr), &Lanes::all(0))
            }
            Expression::Select { condition, accept, reject } => {
                self.value(condition).select(&self.value(accept), &self.value(reject))
            }
            Expression::Math { fun, arg, arg1, .. } => {
                let second = arg1.map(|arg| self.value(arg));
                Lanes::math(fun, &self.value(arg), second.as_ref())
            }
            // Floats are never known, so this is between integers.
            Expression::As { expr, .. } => self.value(expr),
            _ => Lanes::UNKNOWN,
        }
    }

    fn load(&self, pointer: Handle<Expression>) -> Lanes {
        match self.function.expressions[pointer] {
            Expression::LocalVariable(variable) => {
                self.locals.get(&variable).copied().unwrap_or(Lanes::UNKNOWN)
            }
            Expression::AccessIndex { base, index } => {
                let Expression::GlobalVariable(global) = self.function.expressions[base] else {
                    return Lanes::UNKNOWN;
                };
                let ty = self.module.global_variables[global].ty;
                let TypeInner::Struct { members, .. } = &self.module.types[ty].inner else {
                    return Lanes::UNKNOWN;
                };
                let name = members[index as usize].name.as_deref();
                let known = UNIFORMS.iter().find(|(uniform, _)| name == Some(uniform));
                known.map_or(Lanes::UNKNOWN, |&(_, value)| Lanes::all(value))
            }
            _ => Lanes::UNKNOWN,
        }
    }

    /// Of a constant array.
    fn element(&self, base: Handle<Expression>, index: &Lanes) -> Lanes {
        let module = self.module;
        let components: Vec<_> = match &self.function.expressions[base] {
            Expression::Constant(constant) => {
                match &module.global_expressions[module.constants[*constant].init] {
                    Expression::Compose { components, .. } => {
                        components.iter().map(|&part| &module.global_expressions[part]).collect()
                    }
                    _ => return Lanes::UNKNOWN,
                }
            }
            Expression::Compose { components, .. } => {
                components.iter().map(|&part| &self.function.expressions[part]).collect()
            }
            _ => return Lanes::UNKNOWN,
        };
        let mut found = Lanes::UNKNOWN;
        for (lane, &at) in index.values.iter().enumerate() {
            let part = usize::try_from(at).ok().and_then(|at| components.get(at));
            if let (Some(Expression::Literal(literal)), 1) = (part, index.known >> lane & 1) {
                found.assign(&Lanes::literal(*literal), 1 << lane);
            }
        }
        found
    }
}
