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
