//! The section about a still view over many frames.

use super::super::convergence::SPP;
use super::super::plot;
use super::super::report::{ConvergenceReport, StillnessReport};
use super::number;
use crate::html::fill;
use std::fmt::Write;

pub fn section(report: &ConvergenceReport) -> String {
    fill(
        include_str!("convergence.html"),
        &[
            ("spp", SPP.to_string()),
            ("max_history", report.max_history.to_string()),
            ("plot", plot::convergence(report)),
            ("table", errors(report)),
            ("stillness", report.stillness.as_ref().map(stillness).unwrap_or_default()),
        ],
    )
}

fn errors(report: &ConvergenceReport) -> String {
    let labels: String = report.methods.iter().map(|method| format!("<th>{}</th>", method.label)).collect();
    let mut out = format!("<table><tr><th>frames</th>{labels}</tr>");
    for (i, frames) in report.frames.iter().enumerate() {
        let _ = write!(out, "<tr><td>{frames}</td>");
        for method in &report.methods {
            let _ = write!(out, "<td>{:.3}</td>", 1e3 * method.mse[i]);
        }
        out += "</tr>";
    }
    out += "<tr class=\"figure\"><td>slope</td>";
    for method in &report.methods {
        let slope = method.slope.map_or("–".to_owned(), |slope| format!("{slope:.2}").replace('-', "−"));
        let _ = write!(out, "<td>{slope}</td>");
    }
    out + "</tr></table>"
}

/// Steps of an 8-bit image from black to white.
const STEPS: f64 = 255.0;

fn stillness(report: &StillnessReport) -> String {
    let mut table = "<table><tr><th></th><th>pixels</th><th>blurred</th></tr>".to_owned();
    for method in &report.methods {
        let [pixels, blurred] = [method.variance, method.blurred].map(|variance| STEPS * variance.sqrt());
        let _ = write!(table, "<tr><td>{}</td><td>{pixels:.3}</td><td>{blurred:.3}</td></tr>", method.label);
    }
    let _ = write!(
        table,
        "<tr class=\"figure\"><td>variance with innovation / without</td><td>{}</td><td>{}</td></tr></table>",
        number(report.innovation_ratio),
        number(report.innovation_blurred_ratio)
    );
    fill(
        include_str!("stillness.html"),
        &[
            ("max_history", report.max_history.to_string()),
            ("first", report.first_frame.to_string()),
            ("last", report.last_frame.to_string()),
            ("blur", report.blur_px.to_string()),
            ("table", table),
        ],
    )
}
