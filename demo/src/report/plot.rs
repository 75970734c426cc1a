//! Errors over frames, one line per method.

use super::events::Event;
use super::numbers::{MethodReport, StretchReport, is_denoiser, label};
use crate::plot::{Area, axis_title, start, x_axis, y_axis};
use crate::quality::FrameReport;
use std::fmt::Write;

/// What is plotted over frames.
pub struct Measure {
    /// With its unit.
    pub title: &'static str,
    pub way: &'static str,
    pub value: fn(&FrameReport) -> f64,
}

pub const MEASURES: [Measure; 2] = [
    Measure { title: "PSNR, dB", way: "higher is better", value: |frame| frame.metrics.psnr_db },
    Measure { title: "FLIP", way: "lower is better", value: |frame| frame.metrics.flip },
];

/// Evenly spaced round numbers on an axis.
struct Scale {
    low: f64,
    high: f64,
    step: f64,
}

/// Marks an axis has, about.
const MARKS: f64 = 6.0;

impl Scale {
    /// From a mark below all values to one above.
    fn of(values: impl Iterator<Item = f64>, least_step: f64) -> Self {
        let finite = values.filter(|value| value.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let rough = ((high - low) / MARKS).max(least_step);
        let decade = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|step| *step >= 0.999 * rough);
        let step = step.unwrap_or(rough);
        let (low, high) = ((low / step).floor() * step, (high / step).ceil() * step);
        Self { low, high: if high > low { high } else { low + step }, step }
    }

    /// 0 at the low end, 1 at the high one, and no further: equal images have an infinite PSNR.
    fn place(&self, value: f64) -> f64 {
        ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    fn marks(&self) -> impl Iterator<Item = (f64, String)> {
        let decimals = (-self.step.log10().floor()).max(0.0) as usize;
        let count = ((self.high - self.low) / self.step).round() as i32;
        (0..=count).map(move |i| {
            let value = self.low + f64::from(i) * self.step;
            (self.place(value), format!("{value:.decimals$}"))
        })
    }
}

/// A number for each of the denoisers of a stretch, by which lines and keys get their looks.
fn looks(stretch: &StretchReport) -> impl Iterator<Item = (usize, &MethodReport)> {
    stretch.methods.iter().enumerate().filter(|(_, method)| is_denoiser(method.numbers.method))
}

pub fn over_frames(stretch: &StretchReport, measure: &Measure) -> String {
    let area = Area { left: 78.0, top: 26.0, width: 492.0, height: 250.0 };
    let values = looks(stretch).flat_map(|(_, method)| &method.frames).map(measure.value);
    let scale = Scale::of(values, 1e-6);
    let measured = || looks(stretch).flat_map(|(_, method)| &method.frames).map(|frame| frame.frame as f64);
    let frames = Scale::of(measured(), 1.0);
    let x = |frame: f64| area.left + frames.place(frame) * area.width;
    let mut svg = start(&format!("{} over frames", measure.title), &area);
    y_axis(&mut svg, &area, scale.marks(), measure.title);
    x_axis(&mut svg, &area, frames.marks());
    axis_title(&mut svg, &area, "frame");
    let is_within = |event: &&Event| (frames.low..=frames.high).contains(&f64::from(event.frame));
    for event in stretch.events.iter().filter(is_within) {
        // The change lies between two frames.
        let x = x(f64::from(event.frame) - 0.5);
        let anchor = if x > area.left + 0.8 * area.width { "end" } else { "middle" };
        let _ = write!(
            svg,
            "<line class=\"event\" x1=\"{x:.1}\" y1=\"{}\" x2=\"{x:.1}\" y2=\"{}\"/>\
             <text class=\"event\" x=\"{x:.1}\" y=\"{}\" text-anchor=\"{anchor}\">{}</text>",
            area.top,
            area.top + area.height,
            area.top - 8.0,
            crate::html::escape(&event.label)
        );
    }
    // The first methods last, above the others.
    let mut lines: Vec<_> = looks(stretch).collect();
    lines.reverse();
    for (look, method) in lines {
        let points = method.frames.iter().map(|frame| {
            let y = area.top + (1.0 - scale.place((measure.value)(frame))) * area.height;
            (x(frame.frame as f64), y, frame)
        });
        let path: Vec<String> = points.clone().map(|(x, y, _)| format!("{x:.1},{y:.1}")).collect();
        let _ = write!(svg, "<polyline class=\"m{look}\" points=\"{}\"/>", path.join(" "));
        for (x, y, frame) in points {
            let value = (measure.value)(frame);
            let name = label(method.numbers.method);
            let _ = write!(
                svg,
                "<g class=\"m{look}\" transform=\"translate({x:.1} {y:.1})\">{}<title>{name}, frame {}: {value:.4}</title></g>",
                marker(look),
                frame.frame
            );
        }
    }
    svg + "</svg>"
}

/// A method's mark about the origin.
fn marker(look: usize) -> &'static str {
    const MARKERS: [&str; 5] = [
        "<circle r=\"4\"/>",
        "<path d=\"M-4-4h8v8h-8z\"/>",
        "<path d=\"M0-5l5 9h-10z\"/>",
        "<path d=\"M0-5.5l5 5.5-5 5.5-5-5.5z\"/>",
        "<path d=\"M0 5l5-9h-10z\"/>",
    ];
    MARKERS[look % MARKERS.len()]
}

/// What the lines are.
pub fn keys(stretch: &StretchReport) -> String {
    let key = |(look, method): (usize, &MethodReport)| {
        format!(
            "<span><svg class=\"plot key\" viewBox=\"0 -8 40 16\" aria-hidden=\"true\"><polyline class=\"m{look}\" \
             points=\"0,0 40,0\"/><g class=\"m{look}\" transform=\"translate(20 0)\">{}</g></svg>{}</span>",
            marker(look),
            label(method.numbers.method)
        )
    };
    looks(stretch).map(key).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_round_and_hold_their_values() {
        let marks = |values: &[f64], least| -> Vec<String> {
            Scale::of(values.iter().copied(), least).marks().map(|(_, label)| label).collect()
        };
        assert_eq!(marks(&[21.3, 27.9, f64::INFINITY], 1e-6), ["20", "22", "24", "26", "28"]);
        assert_eq!(marks(&[0.0, 4.0], 1.0), ["0", "1", "2", "3", "4"]);
        assert_eq!(marks(&[0.051, 0.083], 1e-6), ["0.05", "0.06", "0.07", "0.08", "0.09"]);
        assert_eq!(marks(&[], 1e-6).len(), 6);
        let one = Scale::of([25.0].into_iter(), 1e-6);
        assert!(one.high > one.low && one.place(25.0).is_finite());
        assert_eq!(Scale::of([0.0, 1.0].into_iter(), 1e-6).place(f64::INFINITY), 1.0);
    }
}
