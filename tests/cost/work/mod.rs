//! What a wave of 64 invocations executes: the shader's representation is walked with the numbers that are known without
//! data, such as an invocation's index and loops' bounds, so that loops count as often as they run.

mod call;
mod lanes;
#[cfg(test)]
mod tests;

use crate::shader::Shader;
use call::Call;
use lanes::{Lanes, Mask};
use wgpu::naga::{
    AddressSpace, Binding, Block, BuiltIn, Expression, Function, Handle, Statement, valid::FunctionInfo,
};

pub const RULES: &str = "\
What the busiest invocation of a workgroup executes, from walking the shader with the numbers that are known without data: \
loops count as often as they run, what any invocation of 64 executes counts for all, and of branches that data decide all are \
taken. So a figure is what can happen, not what does. `operations` are on scalars, before a compiler optimises; `shared` and \
`buffers` are words of workgroup memory and of buffers; `texels` are loads of images; at `barriers` the workgroup waits for its slowest invocation. `still`: nothing moves and history is \
long; `moving`, to which the other columns belong: history is resampled; `worst`: history is nearly empty too. Assumed: nine \
models reach a tile; windows of up to 5x5 tiles.";

/// Functions that no pixel calls, or that are false for all, in a still view, in a moving one, at worst.
pub const LEFT_OUT: [&[&str]; 3] = [
    &["is_settled", "is_between_texels", "spatial_spread"],
    &["is_settled", "spatial_spread"],
    &["is_settled"],
];

/// Rounds of a loop of which data decide: models that reach a tile, by windows of 40 pixels and a model for 190.
const ASSUMED_ROUNDS: u32 = 9;
/// After so many rounds a loop that data may end has no other end.
const MOST_ROUNDS: u32 = 64;

/// Of one invocation; what part of a wave executes counts for all of it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// On scalars: a vector's count for each component.
    pub operations: u64,
    /// Words of workgroup memory.
    pub shared: u64,
    /// Words of buffers.
    pub buffers: u64,
    /// Loads of texels.
    pub texels: u64,
    /// Of the workgroup.
    pub barriers: u64,
}

/// Every branch that data decide is taken, but calls of functions in `left_out`.
pub fn of(shader: &Shader, left_out: &[&str]) -> Work {
    let mut walk = Walk { shader, left_out, work: Work::default() };
    let entry = &shader.module.entry_points[0].function;
    let arguments = entry.arguments.iter().map(|argument| match argument.binding {
        Some(Binding::BuiltIn(BuiltIn::LocalInvocationIndex)) => Lanes::index(),
        _ => Lanes::UNKNOWN,
    });
    let lanes = shader.invocations().min(64);
    let mask = Mask::MAX >> (64 - lanes);
    walk.function(entry, shader.info.get_entry_point(0), arguments.collect(), mask);
    walk.work
}

struct Walk<'a> {
    shader: &'a Shader,
    left_out: &'a [&'a str],
    work: Work,
}

impl<'a> Walk<'a> {
    fn function(
        &mut self,
        function: &'a Function,
        info: &'a FunctionInfo,
        arguments: Vec<Lanes>,
        mask: Mask,
    ) -> Lanes {
        let mut call = Call::new(&self.shader.module, function, info, arguments);
        self.block(&mut call, &function.body, mask);
        call.result
    }

    /// Returns which invocations come out of the block's end.
    fn block(&mut self, call: &mut Call<'a>, block: &'a Block, mut mask: Mask) -> Mask {
        for statement in block {
            if mask == 0 {
                break;
            }
            match statement {
                Statement::Emit(range) => {
                    for expression in range.clone() {
                        self.count(call, expression);
                        let value = call.evaluate(expression);
                        call.values.insert(expression, value);
                    }
                }
                Statement::Block(inner) => mask = self.block(call, inner, mask),
                Statement::If { condition, accept, reject } => {
                    mask = self.branch(call, *condition, [accept, reject], mask);
                }
                Statement::Switch { cases, .. } => {
                    let (before, broke) = (self.work, call.broke);
                    // Data choose one of them; the costliest counts.
                    let worst = cases.iter().map(|case| {
                        self.work = before;
                        self.block(call, &case.body, mask);
                        self.work
                    });
                    self.work = worst.max_by_key(|work| work.operations + work.texels).unwrap_or(before);
                    call.broke = broke;
                }
                Statement::Loop { body, continuing, break_if } => {
                    mask = self.rounds(call, [body, continuing], *break_if, mask);
                }
                Statement::Break => return leave(&mut call.broke, mask),
                Statement::Continue => return leave(&mut call.continued, mask),
                Statement::Return { value } => {
                    if let Some(value) = value {
                        let value = call.value(*value);
                        call.result.assign(&value, mask);
                    }
                    return leave(&mut call.returned, mask);
                }
                Statement::Store { pointer, value } => {
                    self.touch(call, *pointer);
                    if let Expression::LocalVariable(variable) = call.function.expressions[*pointer] {
                        let value = call.value(*value);
                        call.locals.entry(variable).or_insert(Lanes::UNKNOWN).assign(&value, mask);
                    }
                }
                Statement::ControlBarrier(_) => self.work.barriers += 1,
                Statement::ImageStore { .. } => self.work.operations += 1,
                Statement::Atomic { pointer, .. } => self.touch(call, *pointer),
                Statement::Call { function, arguments, result } => {
                    let callee = &self.shader.module.functions[*function];
                    let left_out = callee.name.as_deref().is_some_and(|name| self.left_out.contains(&name));
                    let arguments: Vec<_> = arguments.iter().map(|&argument| call.value(argument)).collect();
                    let value = if left_out || is_off_by_default(callee, &arguments) {
                        Lanes::all(0)
                    } else {
                        self.function(callee, &self.shader.info[*function], arguments, mask)
                    };
                    if let Some(result) = result {
                        call.values.insert(*result, value);
                    }
                }
                _ => {}
            }
        }
        mask
    }

    /// Invocations of which the condition is not known take both ways.
    fn branch(
        &mut self,
        call: &mut Call<'a>,
        condition: Handle<Expression>,
        ways: [&'a Block; 2],
        mask: Mask,
    ) -> Mask {
        let condition = call.value(condition);
        let unsure = mask & !condition.known;
        let masks =
            [mask & condition.nonzero() | unsure, mask & condition.known & !condition.nonzero() | unsure];
        let before = call.locals.clone();
        let left = [call.broke, call.continued, call.returned];
        let accepted = self.block(call, ways[0], masks[0]);
        let after = call.locals.clone();
        for (variable, lanes) in &mut call.locals {
            lanes.assign(before.get(variable).unwrap_or(&Lanes::UNKNOWN), unsure);
        }
        let rejected = self.block(call, ways[1], masks[1]);
        for (variable, lanes) in &mut call.locals {
            lanes.agree(after.get(variable).unwrap_or(&Lanes::UNKNOWN), unsure);
        }
        // Who may have come out did not leave.
        let out = accepted | rejected;
        call.may_end |= (call.broke & !left[0]) & out != 0;
        call.broke &= !out | left[0];
        call.continued &= !out | left[1];
        call.returned &= !out | left[2];
        out
    }

    fn rounds(
        &mut self,
        call: &mut Call<'a>,
        [body, continuing]: [&'a Block; 2],
        break_if: Option<Handle<Expression>>,
        mask: Mask,
    ) -> Mask {
        let outer = (call.broke, call.continued, call.may_end);
        let returned = call.returned;
        let mut active = mask;
        let mut assumed = None;
        for round in 1.. {
            (call.broke, call.continued, call.may_end) = (0, 0, false);
            active = self.block(call, body, active) | call.continued;
            active = self.block(call, continuing, active);
            if let Some(condition) = break_if {
                active &= !call.value(condition).nonzero();
            }
            if active == 0 {
                break;
            }
            // Data may end it; if nothing else does, it is taken to have ended here.
            if call.may_end && round == ASSUMED_ROUNDS {
                assumed = Some(self.work);
            }
            if let Some(work) = assumed.filter(|_| round == MOST_ROUNDS) {
                self.work = work;
                break;
            }
            assert!(round < 10_000, "{}: a loop without a bound that is known", self.shader.name());
        }
        (call.broke, call.continued, call.may_end) = outer;
        mask & !(call.returned & !returned)
    }

    fn count(&mut self, call: &Call<'_>, expression: Handle<Expression>) {
        match call.function.expressions[expression] {
            Expression::Load { pointer } => self.touch(call, pointer),
            Expression::ImageLoad { .. } => self.work.texels += 1,
            Expression::Math { arg, .. } | Expression::Relational { argument: arg, .. } => {
                self.work.operations += call.scalars(arg).max(call.scalars(expression));
            }
            Expression::Unary { .. }
            | Expression::Binary { .. }
            | Expression::Select { .. }
            | Expression::As { .. } => self.work.operations += call.scalars(expression),
            // Moves, which compilers do away with.
            _ => {}
        }
    }

    /// Counts what a pointer's memory delivers or takes.
    fn touch(&mut self, call: &Call<'_>, pointer: Handle<Expression>) {
        let mut root = pointer;
        while let Expression::Access { base, .. } | Expression::AccessIndex { base, .. } =
            call.function.expressions[root]
        {
            root = base;
        }
        let Expression::GlobalVariable(global) = call.function.expressions[root] else { return };
        let words = call.scalars(pointer);
        match self.shader.module.global_variables[global].space {
            AddressSpace::WorkGroup => self.work.shared += words,
            AddressSpace::Storage { .. } => self.work.buffers += words,
            // Uniforms are the same for all invocations.
            _ => {}
        }
    }
}

/// Whether a flag is asked for that the defaults do not set, of those that decide how often a loop runs.
fn is_off_by_default(callee: &Function, arguments: &[Lanes]) -> bool {
    let is_ring_error = |flag: &Lanes| *flag == Lanes::all(quell::gpu::flags::RING_ERROR.into());
    callee.name.as_deref() == Some("has") && arguments.last().is_some_and(is_ring_error)
}

fn leave(place: &mut Mask, mask: Mask) -> Mask {
    *place |= mask;
    0
}
