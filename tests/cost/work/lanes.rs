//! Integers of a wave of 64 invocations, as far as they are known without running the shader.

use wgpu::naga::{BinaryOperator, Literal, MathFunction};

pub const LANES: usize = 64;

/// A bit per invocation.
pub type Mask = u64;

/// What each invocation has for a value; booleans are 0 and 1. Where the bit of `known` is 0, nothing is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lanes {
    pub values: [i64; LANES],
    pub known: Mask,
}

impl Lanes {
    pub const UNKNOWN: Self = Self { values: [0; LANES], known: 0 };

    pub fn all(value: i64) -> Self {
        Self { values: [value; LANES], known: Mask::MAX }
    }

    /// `local_invocation_index`.
    pub fn index() -> Self {
        Self { values: std::array::from_fn(|lane| lane as i64), known: Mask::MAX }
    }

    pub fn literal(literal: Literal) -> Self {
        match literal {
            Literal::U32(value) => Self::all(value.into()),
            Literal::I32(value) => Self::all(value.into()),
            Literal::U64(value) => value.try_into().map_or(Self::UNKNOWN, Self::all),
            Literal::I64(value) | Literal::AbstractInt(value) => Self::all(value),
            Literal::Bool(value) => Self::all(value.into()),
            _ => Self::UNKNOWN,
        }
    }

    /// Invocations that have another value than 0, of those that are known.
    pub fn nonzero(&self) -> Mask {
        self.values.iter().enumerate().fold(0, |mask, (lane, &value)| mask | Mask::from(value != 0) << lane)
            & self.known
    }

    /// Takes over another's values where the mask has a bit.
    pub fn assign(&mut self, other: &Self, mask: Mask) {
        for lane in 0..LANES {
            if mask >> lane & 1 != 0 {
                self.values[lane] = other.values[lane];
            }
        }
        self.known = self.known & !mask | other.known & mask;
    }

    /// Forgets where the other differs, among those of the mask.
    pub fn agree(&mut self, other: &Self, mask: Mask) {
        for lane in 0..LANES {
            if mask >> lane & 1 != 0 && self.values[lane] != other.values[lane] {
                self.known &= !(1 << lane);
            }
        }
        self.known &= other.known | !mask;
    }

    pub fn select(&self, accept: &Self, reject: &Self) -> Self {
        let mut chosen = *reject;
        chosen.assign(accept, self.nonzero());
        // Either way, where the condition is not known.
        chosen.agree(accept, !self.known);
        chosen
    }

    pub fn binary(op: BinaryOperator, left: &Self, right: &Self) -> Self {
        use BinaryOperator as Op;
        let of = |f: fn(i64, i64) -> Option<i64>| Self::zip(left, right, f);
        match op {
            Op::Add => of(i64::checked_add),
            Op::Subtract => of(i64::checked_sub),
            Op::Multiply => of(i64::checked_mul),
            Op::Divide => of(i64::checked_div),
            Op::Modulo => of(i64::checked_rem),
            Op::And => of(|a, b| Some(a & b)),
            Op::InclusiveOr => of(|a, b| Some(a | b)),
            Op::ExclusiveOr => of(|a, b| Some(a ^ b)),
            Op::ShiftLeft => of(|a, b| a.checked_shl(b.try_into().ok()?)),
            Op::ShiftRight => of(|a, b| a.checked_shr(b.try_into().ok()?)),
            Op::Equal => of(|a, b| Some((a == b).into())),
            Op::NotEqual => of(|a, b| Some((a != b).into())),
            Op::Less => of(|a, b| Some((a < b).into())),
            Op::LessEqual => of(|a, b| Some((a <= b).into())),
            Op::Greater => of(|a, b| Some((a > b).into())),
            Op::GreaterEqual => of(|a, b| Some((a >= b).into())),
            Op::LogicalAnd => {
                let mut both = of(|a, b| Some(a & b));
                // One that is false decides.
                let decided = left.known & !left.nonzero() | right.known & !right.nonzero();
                both.assign(&Self::all(0), decided);
                both
            }
            Op::LogicalOr => {
                let mut either = of(|a, b| Some(a | b));
                either.assign(&Self::all(1), left.nonzero() | right.nonzero());
                either
            }
        }
    }

    pub fn math(fun: MathFunction, first: &Self, second: Option<&Self>) -> Self {
        match (fun, second) {
            (MathFunction::Min, Some(second)) => Self::zip(first, second, |a, b| Some(a.min(b))),
            (MathFunction::Max, Some(second)) => Self::zip(first, second, |a, b| Some(a.max(b))),
            _ => Self::UNKNOWN,
        }
    }

    fn zip(left: &Self, right: &Self, f: impl Fn(i64, i64) -> Option<i64>) -> Self {
        let mut result = Self { values: [0; LANES], known: left.known & right.known };
        for lane in 0..LANES {
            match f(left.values[lane], right.values[lane]) {
                Some(value) => result.values[lane] = value,
                None => result.known &= !(1 << lane),
            }
        }
        result
    }
}

#[test]
fn what_is_not_known_stays_unknown_unless_the_rest_decides() {
    let index = Lanes::index();
    let below = Lanes::binary(BinaryOperator::Less, &index, &Lanes::all(3));
    assert_eq!(below.nonzero(), 0b111);
    let and = Lanes::binary(BinaryOperator::LogicalAnd, &below, &Lanes::UNKNOWN);
    assert_eq!((and.known, and.nonzero()), (!0b111, 0));
    let or = Lanes::binary(BinaryOperator::LogicalOr, &below, &Lanes::UNKNOWN);
    assert_eq!((or.known, or.nonzero()), (0b111, 0b111));
    assert_eq!(Lanes::binary(BinaryOperator::Divide, &index, &index).known, !1);
}
