//! The page: one HTML file that needs nothing else.

mod convergence;

use super::plot::{curves, histogram};
use super::report::{ChoiceReport, Correlation, Rect, StudyReport, VariantReport, WindowReport};
use super::surfaces::TILE;
use crate::html::{escape, fill, png_source};
use crate::metrics::FrameMetrics;
use crate::plot::LogRange;
use anyhow::{Context, Result};
use std::fmt::Write;
use std::path::Path;

/// The folder with the page's PNGs.
struct Pictures<'a>(&'a Path);

/// Names of the three that are shown side by side.
pub const SIDE_BY_SIDE: [&str; 3] = ["dense", "uniform", "adaptive"];

/// Share of the errors at either end that the plots show at their border: a few chance values near 0 are decades away.
const CUT: f64 = 0.002;

/// Writes `study.html` into the folder that holds its pictures. `pairs` are the estimated and true errors that are plotted,
/// per window size.
pub fn write(report: &StudyReport, pairs: &[Vec<[f64; 2]>], out: &Path) -> Result<()> {
    let path = out.join("study.html");
    std::fs::write(&path, page(report, pairs, &Pictures(out))?)
        .with_context(|| format!("{}: cannot write", path.display()))
}

fn page(report: &StudyReport, pairs: &[Vec<[f64; 2]>], pictures: &Pictures<'_>) -> Result<String> {
    let shown = || report.variants.iter().filter(|variant| SIDE_BY_SIDE.contains(&variant.name));
    let picture = |name: &str, caption: &str, over: &str| pictures.figure(name, caption, over);
    let frame = overlay(report, &zoom_frame(report.zoom));
    let images = shown().map(|v| picture(v.name, &caption(v), &frame)).collect::<Result<_>>()?;
    let centres = shown().map(|v| picture(&format!("{}_centres", v.name), "", "")).collect::<Result<_>>()?;
    let zooms = ["noisy", "dense", "uniform", "adaptive", "reference"].into_iter();
    let zooms = zooms.map(|name| picture(&format!("{name}_zoom"), name, "")).collect::<Result<_>>()?;
    let noisy = format!("noisy <small>{}</small>", quality(&report.noisy));
    let reference = format!("reference <small>{} samples per pixel</small>", report.reference_spp);
    let marked = overlay(report, &(zoom_frame(report.zoom) + &marks(report)));
    let ends = picture("noisy", &noisy, &frame)? + &picture("reference", &reference, &marked)?;
    let range = LogRange::of(pairs.iter().flatten().flatten().copied(), CUT);
    let histograms = report.windows.iter().zip(pairs).map(|(window, pairs)| {
        let Correlation { pearson_log, spearman, .. } = window.expected;
        format!(
            "<figure><figcaption>windows of {} pixels<br><small>Pearson on logs {}, Spearman {}</small></figcaption>{}\
             </figure>",
            window.pixels,
            number(pearson_log),
            number(spearman),
            histogram(window, pairs, range)
        )
    });
    let widths: Vec<u32> = report.windows.iter().map(|window| window.pixels).collect();
    let curves = report.pixels.iter().map(|pixel| {
        let (label, at) = (&pixel.label, format!("{}, {}", pixel.x, pixel.y));
        format!(
            "<figure><figcaption>{label} <small>pixel {at}</small></figcaption>{}</figure>",
            curves(pixel, &widths)
        )
    });
    let Rect { x, y, width, height } = report.zoom;
    Ok(fill(
        include_str!("page.html"),
        &[
            ("scene", escape(&report.scene)),
            ("setting", setting(report)),
            ("spp", report.spp.to_string()),
            ("images", images),
            ("centres", centres),
            ("zoom", format!("{width}x{height} pixels from {x}, {y}")),
            ("zooms", zooms),
            ("ends", ends),
            ("table", table(report)),
            ("notes", notes(report)),
            ("tile", format!("{TILE}x{TILE}")),
            ("runs", report.runs.to_string()),
            ("histograms", histograms.collect()),
            ("correlations", correlations(&report.windows)),
            ("curves", curves.collect()),
            ("convergence", report.convergence.as_ref().map(convergence::section).unwrap_or_default()),
            ("choice", report.choice.as_ref().map(|c| choice(c, &widths)).unwrap_or_default()),
        ],
    ))
}

impl Pictures<'_> {
    fn figure(&self, name: &str, caption: &str, over: &str) -> Result<String> {
        let path = self.0.join(format!("{name}.png"));
        let png = std::fs::read(&path).with_context(|| format!("{}: cannot read", path.display()))?;
        let source = png_source(&png);
        let caption =
            if caption.is_empty() { String::new() } else { format!("<figcaption>{caption}</figcaption>") };
        Ok(format!(
            "<figure>{caption}<div class=\"picture\"><img alt=\"{name}\" src=\"{source}\">\
             {over}</div></figure>"
        ))
    }
}

fn overlay(report: &StudyReport, shapes: &str) -> String {
    format!("<svg viewBox=\"0 0 {} {}\">{shapes}</svg>", report.width, report.height)
}

fn zoom_frame(Rect { x, y, width, height }: Rect) -> String {
    format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/>")
}

/// The chosen pixels, in units of the image; letters are a share of its height.
fn marks(report: &StudyReport) -> String {
    let size = f64::from(report.height) / 22.0;
    let mark = |pixel: &super::report::PixelReport| {
        let (x, y) = (f64::from(pixel.x) + 0.5, f64::from(pixel.y) + 0.5);
        let is_right = x > 0.75 * f64::from(report.width);
        let (anchor, side) = if is_right { ("end", -1.0) } else { ("start", 1.0) };
        format!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{:.2}\"/><text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"{anchor}\" \
             font-size=\"{size:.2}\">{}</text>",
            0.35 * size,
            x + side * 0.6 * size,
            y + 0.35 * size,
            pixel.label
        )
    };
    report.pixels.iter().map(mark).collect()
}

fn setting(report: &StudyReport) -> String {
    format!(
        "{}x{} pixels at {} s, {} samples per pixel, seed {}; reference of {} samples per pixel. On {}.",
        report.width,
        report.height,
        report.start_s,
        report.spp,
        report.seed,
        report.reference_spp,
        escape(&report.adapter)
    )
}

/// rMSE as in tables.
fn rmse_text(value: f64) -> String {
    if value >= 1.0 { format!("{value:.3}") } else { format!("{value:.5}") }
}

fn quality(metrics: &FrameMetrics) -> String {
    format!("rMSE {}, PSNR {:.2} dB", rmse_text(metrics.relative_mse), metrics.psnr_db)
}

fn caption(variant: &VariantReport) -> String {
    format!(
        "{} <small>{} models, {:.1} pixels each<br>{}</small>",
        variant.centres,
        variant.models,
        variant.pixels_per_model,
        quality(&variant.output)
    )
}

fn table(report: &StudyReport) -> String {
    let mut out = "<table><tr class=\"groups\"><th></th><th></th><th></th><th></th><th colspan=\"2\">output</th>\
                   <th colspan=\"2\">models alone</th><th></th></tr>\
                   <tr><th>centres</th><th class=\"text\">windows</th><th>models</th><th>pixels per model</th>\
                   <th>rMSE</th><th>PSNR, dB</th><th>rMSE</th><th>PSNR, dB</th><th>time, ms</th></tr>"
        .to_owned();
    let cells = |m: &FrameMetrics| format!("<td>{}</td><td>{:.2}</td>", rmse_text(m.relative_mse), m.psnr_db);
    for v in &report.variants {
        let class = if SIDE_BY_SIDE.contains(&v.name) { " class=\"figure\"" } else { "" };
        let _ = write!(
            out,
            "<tr{class}><td>{}</td><td class=\"text\">{}</td><td>{}</td><td>{:.1}</td>{}{}<td>{:.1}</td></tr>",
            v.centres,
            v.windows,
            v.models,
            v.pixels_per_model,
            cells(&v.output),
            cells(&v.models_alone),
            v.wall_ms
        );
    }
    let _ = write!(
        out,
        "<tr><td>noisy input</td><td></td><td></td><td></td>{}<td></td><td></td><td></td></tr></table>",
        cells(&report.noisy)
    );
    out
}

fn notes(report: &StudyReport) -> String {
    let machine = if report.is_cpu {
        "a CPU: they are no benchmark of a GPU, but the work of the variants compares"
    } else {
        "with what submitting and waiting costs"
    };
    format!(
        "Times are medians of whole frames, from submission until done, the variants in turns, on {}, {machine}. About {} \
         of every rMSE is the reference's own noise.",
        escape(&report.adapter),
        rmse_text(report.reference_relative_mse)
    )
}

fn number(correlation: Option<f64>) -> String {
    correlation.map_or("–".to_owned(), |value| format!("{value:.3}"))
}

fn correlations(windows: &[WindowReport]) -> String {
    let mut out = "<table><tr class=\"groups\"><th></th><th></th><th colspan=\"2\">expected error</th>\
                   <th colspan=\"2\">of one image</th><th></th><th></th></tr>\
                   <tr><th>window, pixels</th><th>tiles</th><th>Pearson, logs</th><th>Spearman</th>\
                   <th>Pearson, logs</th><th>Spearman</th><th>estimated / true, median</th>\
                   <th>tiles without logarithm</th></tr>"
        .to_owned();
    let cells =
        |c: &Correlation| format!("<td>{}</td><td>{}</td>", number(c.pearson_log), number(c.spearman));
    for w in windows {
        let _ = write!(
            out,
            "<tr><td>{}</td><td>{}</td>{}{}<td>{}</td><td>{}</td></tr>",
            w.pixels,
            w.tiles,
            cells(&w.expected),
            cells(&w.own),
            w.median_ratio.map_or("–".to_owned(), |ratio| format!("{ratio:.2}")),
            w.expected.without_log
        );
    }
    out + "</table>"
}

fn choice(choice: &ChoiceReport, widths: &[u32]) -> String {
    let mut out = "<p>What the choice is worth over the whole image, with dense centres and each tile's window chosen on its \
                   own: the mean squared error over (true luminance² + 0.01).</p>\
                   <table><tr><th>window</th><th>relative error</th><th>best in</th></tr>"
        .to_owned();
    for ((width, error), share) in widths.iter().zip(&choice.fixed).zip(&choice.best_shares) {
        let _ = write!(
            out,
            "<tr><td>{width} pixels everywhere</td><td>{}</td><td>{:.1} % of tiles</td></tr>",
            rmse_text(*error),
            100.0 * share
        );
    }
    let _ = write!(
        out,
        "<tr class=\"figure\"><td>least estimated error</td><td>{}</td><td>{:.1} % are the best one</td></tr>\
         <tr><td>least true error, which only the reference knows</td><td>{}</td><td></td></tr></table>",
        rmse_text(choice.estimated),
        100.0 * choice.agreement,
        rmse_text(choice.best)
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_large_errors_have_digits() {
        assert_eq!(rmse_text(0.012_345_6), "0.01235");
        assert_eq!(rmse_text(12.345_6), "12.346");
    }
}
