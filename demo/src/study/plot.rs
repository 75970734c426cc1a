//! Plots as inline SVG. Their text is set by the page's style; axes are logarithmic where they show errors.

use super::report::{ConvergenceReport, PixelReport, WindowReport};
use crate::plot::{Area, axis_title, start, x_axis, y_axis};
use std::fmt::Write;

/// From 10^`low` to 10^`high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogRange {
    low: f64,
    high: f64,
}

impl LogRange {
    /// A range with some room that holds all values above 0 but the `cut` share at either end.
    pub fn of(values: impl Iterator<Item = f64>, cut: f64) -> Self {
        let mut logs: Vec<f64> = values.filter(|value| *value > 0.0).map(f64::log10).collect();
        logs.sort_by(f64::total_cmp);
        let beyond = (cut * logs.len() as f64) as usize;
        let [Some(low), Some(high)] = [logs.get(beyond), logs.iter().rev().nth(beyond)] else {
            return Self { low: -1.0, high: 0.0 };
        };
        let room = 0.04 * (high - low) + 0.05;
        Self { low: low - room, high: high + room }
    }

    /// 0 at the low end, 1 at the high one, and no further.
    fn place(self, value: f64) -> f64 {
        ((value.max(1e-300).log10() - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// Values to mark: powers of ten, with 2 and 5 between where there would be few.
    fn ticks(self) -> Vec<f64> {
        let steps: &[f64] = if self.high - self.low > 2.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
        all.filter(|value| (self.low..=self.high).contains(&value.log10())).collect()
    }

    /// Places and labels of the ticks.
    fn marks(self) -> impl Iterator<Item = (f64, String)> {
        self.ticks().into_iter().map(move |tick| (self.place(tick), tick_label(tick)))
    }
}

/// A tick's label: `0.02`, or a power of ten where that would be long.
fn tick_label(value: f64) -> String {
    // A hair more, since powers of ten are not exact.
    let exponent = (value * 1.000_001).log10().floor();
    let digit = (value / 10f64.powf(exponent)).round();
    if (-2.0..=3.0).contains(&exponent) {
        let decimals = (-exponent).max(0.0) as usize;
        return format!("{value:.decimals$}");
    }
    let factor = if digit == 1.0 { String::new() } else { format!("{digit}·") };
    let raised = |c: char| {
        c.to_digit(10)
            .map_or('⁻', |digit| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize])
    };
    format!("{factor}10{}", format!("{exponent}").chars().map(raised).collect::<String>())
}

/// Cells of a histogram along each axis.
const CELLS: usize = 44;

/// Estimated error (across) and true error (up) of all tiles as a 2D histogram; `range` is that of both axes.
pub fn histogram(window: &WindowReport, pairs: &[[f64; 2]], range: LogRange) -> String {
    let area = Area { left: 62.0, top: 12.0, width: 308.0, height: 308.0 };
    let mut counts = vec![0u32; CELLS * CELLS];
    let cell = |value: f64| ((range.place(value) * CELLS as f64) as usize).min(CELLS - 1);
    for pair in pairs {
        counts[cell(pair[1]) * CELLS + cell(pair[0])] += 1;
    }
    let most = f64::from(counts.iter().copied().max().unwrap_or(0).max(1));
    let mut svg = start(&format!("Estimated against true error, windows of {} pixels", window.pixels), &area);
    y_axis(&mut svg, &area, range.marks(), "true error");
    x_axis(&mut svg, &area, range.marks());
    axis_title(&mut svg, &area, "estimated error");
    let (w, h) = (area.width / CELLS as f64, area.height / CELLS as f64);
    for (i, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let (x, y) =
            (area.left + (i % CELLS) as f64 * w, area.top + area.height - (i / CELLS + 1) as f64 * h);
        let opacity = 0.12 + 0.88 * f64::from(count).ln_1p() / most.ln_1p();
        let _ = write!(
            svg,
            "<rect class=\"cell\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" \
             fill-opacity=\"{opacity:.2}\"><title>{count} tiles</title></rect>"
        );
    }
    let _ = write!(
        svg,
        "<line class=\"equal\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>",
        area.left,
        area.top + area.height,
        area.left + area.width,
        area.top
    );
    svg + "</svg>"
}

/// Errors over window size at one pixel: the true one, the estimate of the first run, and those of the others, faint.
pub fn curves(pixel: &PixelReport, widths_px: &[u32]) -> String {
    let area = Area { left: 62.0, top: 12.0, width: 308.0, height: 210.0 };
    let estimates = pixel.estimated_error.iter().flatten();
    let range = LogRange::of(estimates.chain(&pixel.true_error).copied(), 0.0);
    let mut svg = start(&format!("Errors over window size at pixel {}, {}", pixel.x, pixel.y), &area);
    y_axis(&mut svg, &area, range.marks(), "squared error");
    let across = |i: usize| (i as f64 + 0.5) / widths_px.len() as f64;
    x_axis(&mut svg, &area, widths_px.iter().enumerate().map(|(i, width)| (across(i), width.to_string())));
    axis_title(&mut svg, &area, "window, pixels");
    let mut line = |class: &str, errors: &[f64]| {
        let at = |(i, error): (usize, &f64)| {
            (area.left + across(i) * area.width, area.top + (1.0 - range.place(*error)) * area.height)
        };
        let points: Vec<(f64, f64)> = errors.iter().enumerate().map(at).collect();
        let path: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = write!(svg, "<polyline class=\"{class}\" points=\"{}\"/>", path.join(" "));
        for (x, y) in points.iter().filter(|_| class != "other") {
            let _ = write!(svg, "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>");
        }
    };
    let (first, others) = match pixel.estimated_error.split_first() {
        Some((first, others)) => (first.as_slice(), others),
        None => (&[][..], &[][..]),
    };
    others.iter().for_each(|estimate| line("other", estimate));
    line("estimated", first);
    line("true", &pixel.true_error);
    svg + "</svg>"
}

/// Errors of all methods over the number of frames, and the slope of what averages independent samples.
pub fn convergence(report: &ConvergenceReport) -> String {
    let area = Area { left: 74.0, top: 12.0, width: 560.0, height: 340.0 };
    let errors = LogRange::of(report.methods.iter().flat_map(|method| &method.mse).copied(), 0.0);
    let frames = LogRange::of(report.frames.iter().copied().map(f64::from), 0.0);
    let at = |frame: f64, error: f64| {
        let (x, y) = (frames.place(frame), 1.0 - errors.place(error));
        (area.left + x * area.width, area.top + y * area.height)
    };
    let mut svg = start("Error over the number of frames", &area);
    y_axis(&mut svg, &area, errors.marks(), "mean squared error, as shown");
    let places = report.frames.iter().map(|&frame| (frames.place(f64::from(frame)), frame.to_string()));
    x_axis(&mut svg, &area, places);
    axis_title(&mut svg, &area, "frames");
    let ends = [report.frames.first(), report.frames.last()].map(|frame| frame.copied().map(f64::from));
    let plain = report.methods.last().and_then(|method| method.mse.last());
    if let ([Some(first), Some(last)], Some(&plain)) = (ends, plain) {
        // Through where plain accumulation ends, as far up as there is room.
        let from = first.max(plain * last / 10f64.powf(errors.high));
        let ((x1, y1), (x2, y2)) = (at(from, plain * last / from), at(last, plain));
        let _ = write!(
            svg,
            "<line class=\"equal\" x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"/>"
        );
    }
    for method in &report.methods {
        let frames = report.frames.iter().copied().map(f64::from);
        let points: Vec<(f64, f64)> = frames.zip(&method.mse).map(|(frame, &mse)| at(frame, mse)).collect();
        let path: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let class = method.name;
        let _ = write!(svg, "<polyline class=\"{class}\" points=\"{}\"/>", path.join(" "));
        for (x, y) in points {
            let _ = write!(svg, "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>");
        }
    }
    svg + "</svg>"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_their_values_and_have_ticks() {
        let range = LogRange::of([0.02, 30.0, 0.0].into_iter(), 0.0);
        assert!(range.place(0.02) > 0.0 && range.place(30.0) < 1.0 && range.place(0.02) < range.place(30.0));
        assert_eq!(range.place(0.0), 0.0, "what has no logarithm lies on the axis");
        assert_eq!(range.ticks().iter().map(|&t| tick_label(t)).collect::<Vec<_>>(), ["0.1", "1", "10"]);
        let narrow = LogRange::of([0.013, 0.06].into_iter(), 0.0);
        assert_eq!(narrow.ticks().iter().map(|&t| tick_label(t)).collect::<Vec<_>>(), ["0.02", "0.05"]);
        assert!(!LogRange::of(std::iter::empty(), 0.0).ticks().is_empty());
        assert_eq!([1e-5, 2e-5, 1e4, 0.05, 200.0].map(tick_label), ["10⁻⁵", "2·10⁻⁵", "10⁴", "0.05", "200"]);
        let cut = LogRange::of((0..100).map(|i| 10f64.powi(i)), 0.1);
        assert!((6.0..10.0).contains(&cut.low) && (89.0..93.0).contains(&cut.high), "{cut:?}");
    }
}
