//! Percentiles of a list of times.

use serde::Serialize;

/// What most frames take, and what the slow ones do.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Percentiles {
    pub median: f64,
    pub p95: f64,
    pub p99: f64,
}

impl Percentiles {
    /// Of `values` in any order; NaN where there are none.
    pub fn of(values: &[f64]) -> Self {
        let sorted = sorted(values);
        let at = |fraction| percentile(&sorted, fraction);
        Self { median: at(0.5), p95: at(0.95), p99: at(0.99) }
    }

    /// The value below which `fraction` of the values lie; NaN where there are none.
    pub fn at(values: &[f64], fraction: f64) -> f64 {
        percentile(&sorted(values), fraction)
    }
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// The value below which `fraction` of the values lie, linear between the two nearest (as numpy's default).
fn percentile(sorted: &[f64], fraction: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let rank = fraction * last as f64;
    let below = rank.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (rank - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_lie_between_the_nearest_values_whatever_their_order() {
        // 0 to 100, shuffled: 37 has no factor in common with 101.
        let values: Vec<f64> = (0..101).map(|i| f64::from(i * 37 % 101)).collect();
        assert_eq!(Percentiles::of(&values), Percentiles { median: 50.0, p95: 95.0, p99: 99.0 });
        assert_eq!(Percentiles::of(&[4.0, 1.0]).median, 2.5);
        let of_five = Percentiles::of(&[5.0, 1.0, 2.0, 4.0, 3.0]);
        assert_eq!(of_five.median, 3.0);
        assert!((of_five.p95 - 4.8).abs() < 1e-12 && (of_five.p99 - 4.96).abs() < 1e-12, "{of_five:?}");
    }

    #[test]
    fn a_slow_frame_moves_the_tail_and_not_the_median() {
        let mut values = vec![1.0; 99];
        values.push(50.0);
        let Percentiles { median, p95, p99 } = Percentiles::of(&values);
        assert_eq!((median, p95), (1.0, 1.0));
        assert!(p99 > 1.0 && p99 < 50.0, "{p99}");
    }

    #[test]
    fn one_value_is_every_percentile_and_none_is_nan() {
        assert_eq!(Percentiles::of(&[3.0]), Percentiles { median: 3.0, p95: 3.0, p99: 3.0 });
        assert!(Percentiles::of(&[]).median.is_nan());
    }
}
