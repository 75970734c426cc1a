//! Plots as inline SVG. Their text is set by the page's style; axes are logarithmic where they show errors.

use super::report::{ConvergenceReport, PixelReport, WindowReport};
use crate::plot::{Area, LogRange, axis_title, start, x_axis, y_axis};
use std::fmt::Write;

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
