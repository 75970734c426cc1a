//! How time and memory grow with the number of pixels.

use crate::bench::report::{BenchReport, MethodReport};
use crate::method::Method;
use serde::Serialize;
use std::fmt;

/// Slopes of logarithms over the logarithm of the number of pixels, by least squares: 1 is as fast as the pixels. None from fewer
/// than two sizes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Growth {
    pub time: Option<f64>,
    pub memory: Option<f64>,
}

impl Growth {
    pub fn of(report: &BenchReport, method: Method) -> Self {
        let slope = |value: fn(&MethodReport) -> f64| slope(&points(report, method.name(), value));
        Self {
            time: slope(|found| found.frame_ms.median),
            memory: slope(|found| found.memory.total_bytes as f64),
        }
    }
}

/// Pixels and a value of a method, by size.
pub fn points(report: &BenchReport, method: &str, value: fn(&MethodReport) -> f64) -> Vec<[f64; 2]> {
    let of_size = report.sizes.iter().filter_map(|size| {
        let found = size.methods.iter().find(|found| found.method == method)?;
        Some([f64::from(size.width) * f64::from(size.height), value(found)])
    });
    of_size.collect()
}

fn slope(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> = points.iter().map(|point| point.map(f64::ln)).collect();
    let mean = |axis: usize| logs.iter().map(|log| log[axis]).sum::<f64>() / logs.len() as f64;
    let [x, y] = [0, 1].map(mean);
    let spread: f64 = logs.iter().map(|log| (log[0] - x).powi(2)).sum();
    let product: f64 = logs.iter().map(|log| (log[0] - x) * (log[1] - y)).sum();
    (spread > 0.0).then(|| product / spread)
}

impl fmt::Display for Growth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.time, self.memory) {
            (Some(time), Some(memory)) => write!(
                f,
                "quell grows with the pixels to the power of {time:.2} in time and {memory:.2} in memory"
            ),
            _ => write!(f, "one size says nothing of growth"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_the_power() {
        let of = |power: f64| [1e4, 3e4, 1e6].map(|pixels: f64| [pixels, 5.0 * pixels.powf(power)]);
        for power in [0.0, 0.8, 1.0] {
            assert!((slope(&of(power)).unwrap() - power).abs() < 1e-9, "{power}");
        }
        assert_eq!(slope(&[[100.0, 1.0]]), None);
        assert_eq!(slope(&[[100.0, 1.0], [100.0, 2.0]]), None, "one size twice");
        let none = Growth { time: None, memory: None };
        assert_eq!(none.to_string(), "one size says nothing of growth");
    }
}
