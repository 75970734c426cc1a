//! Plots as inline SVG: what all have in common. Their text is set by the page's style.

use std::fmt::Write;

/// Where a plot's axes lie, in SVG units.
pub struct Area {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

/// Opens an SVG with room for an area and the labels about it.
pub fn start(label: &str, area: &Area) -> String {
    let (width, height) = (area.left + area.width + 10.0, area.top + area.height + 50.0);
    format!("<svg class=\"plot\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\">")
}

/// The frame, and ticks at places from 0 (below) to 1.
pub fn y_axis(svg: &mut String, area: &Area, ticks: impl Iterator<Item = (f64, String)>, title: &str) {
    let Area { left, top, width, height } = *area;
    let _ =
        write!(svg, "<rect class=\"frame\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>");
    for (place, label) in ticks {
        let y = top + (1.0 - place) * height;
        let right = left + width;
        let _ = write!(
            svg,
            "<line class=\"grid\" x1=\"{left}\" y1=\"{y:.1}\" x2=\"{right}\" y2=\"{y:.1}\"/>\
             <text class=\"tick\" x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            left - 6.0,
            y + 4.0
        );
    }
    let middle = top + height / 2.0;
    let _ = write!(
        svg,
        "<text x=\"13\" y=\"{middle}\" text-anchor=\"middle\" transform=\"rotate(-90 13 {middle})\">{title}</text>"
    );
}

/// Ticks at places from 0 to 1.
pub fn x_axis(svg: &mut String, area: &Area, ticks: impl Iterator<Item = (f64, String)>) {
    let bottom = area.top + area.height;
    for (place, label) in ticks {
        let x = area.left + place * area.width;
        let _ = write!(
            svg,
            "<line class=\"grid\" x1=\"{x:.1}\" y1=\"{}\" x2=\"{x:.1}\" y2=\"{bottom}\"/>\
             <text class=\"tick\" x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
            area.top,
            bottom + 18.0
        );
    }
}

pub fn axis_title(svg: &mut String, area: &Area, title: &str) {
    let (x, y) = (area.left + area.width / 2.0, area.top + area.height + 40.0);
    let _ = write!(svg, "<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\">{title}</text>");
}

/// From 10^`low` to 10^`high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogRange {
    pub low: f64,
    pub high: f64,
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
    pub fn place(self, value: f64) -> f64 {
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
    pub fn marks(self) -> impl Iterator<Item = (f64, String)> {
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
