//! The page: one HTML file that needs nothing else.

use super::error_map::MAGMA;
use super::measure::Pictures;
use super::numbers::{MethodReport, NOISY, ShownFrame, StretchReport, SuiteReport, is_denoiser, label};

use super::plot::{MEASURES, Measure, keys, over_frames};
use super::tables;
use crate::html::{escape, fill, png_source};
use crate::image::png_rgb8;
use crate::method::Method;
use crate::study::Rect;
use anyhow::Result;
use std::fmt::Write;

/// Name of the reference among the images.
const REFERENCE: &str = "reference";

/// `pictures` are those of each stretch's shown frames.
pub fn page(report: &SuiteReport, pictures: &[Vec<Pictures>]) -> Result<String> {
    let mut stretches = String::new();
    for (i, (stretch, pictures)) in report.stretches.iter().zip(pictures).enumerate() {
        stretches += &section(i, stretch, pictures)?;
    }
    let links = report.stretches.iter().enumerate();
    let links = links.map(|(i, stretch)| format!("<a href=\"#s{i}\">{}</a>", escape(&stretch.name)));
    let machine = if report.is_cpu { " (a CPU: no benchmark of a GPU)" } else { "" };
    Ok(fill(
        include_str!("page/page.html"),
        &[
            ("style", include_str!("page/style.css").to_owned()),
            ("script", include_str!("page/viewer.js").to_owned()),
            ("setting", format!("On {}{machine}; {}.", escape(&report.adapter), report.clock)),
            ("links", links.collect()),
            ("tiles", tables::tiles(report)),
            ("means", tables::methods(report.summary.iter())),
            ("margins", tables::margins(report)),
            ("stretches", stretches),
        ],
    ))
}

/// Widest that a frame is shown, in CSS pixels.
const STAGE_PX: u32 = 960;

fn section(index: usize, stretch: &StretchReport, pictures: &[Pictures]) -> Result<String> {
    let names = images(stretch);
    let last = stretch.shown.len().saturating_sub(1);
    let mut frames = String::new();
    let mut frame_choices = String::new();
    for (i, (shown, pictures)) in stretch.shown.iter().zip(pictures).enumerate() {
        frames += &frame(stretch, shown, pictures, i == last)?;
        let text = format!("{} <small>{}</small>", shown.frame, escape(&shown.label));
        frame_choices += &choice(index, "frame", &shown.frame.to_string(), &text, i == last);
    }
    let sides = |side: &str, chosen: &str| -> String {
        names.iter().map(|name| choice(index, side, name, label(name), *name == chosen)).collect()
    };
    // Whole multiples keep pixels square.
    let stage = if stretch.width <= STAGE_PX { STAGE_PX / stretch.width * stretch.width } else { STAGE_PX };
    let [.., right, _] = names[..] else { anyhow::bail!("{}: no images", stretch.name) };
    Ok(fill(
        include_str!("page/stretch.html"),
        &[
            ("id", format!("s{index}")),
            ("name", escape(&stretch.name)),
            ("about", about(stretch)),
            ("width", stretch.width.to_string()),
            ("height", stretch.height.to_string()),
            ("stage", stage.to_string()),
            ("frame_choices", frame_choices),
            ("left_choices", sides("left", NOISY)),
            ("right_choices", sides("right", right)),
            ("frames", frames),
            ("table", tables::methods(stretch.methods.iter().map(|method| &method.numbers))),
            ("measured", measured(stretch)),
            ("keys", keys(stretch)),
            ("plots", MEASURES.iter().map(|measure| plot(stretch, measure)).collect()),
        ],
    ))
}

/// Methods, with their numbers in the report, in the order of images: the noisy input, the others, and quell beside the reference.
fn ordered(stretch: &StretchReport) -> Vec<(usize, &MethodReport)> {
    let mut methods: Vec<_> = stretch.methods.iter().enumerate().collect();
    let ours = Method::Quell.name();
    methods.sort_by_key(|(_, method)| (method.numbers.method == ours, is_denoiser(method.numbers.method)));
    methods
}

fn plot(stretch: &StretchReport, measure: &Measure) -> String {
    let Measure { title, way, .. } = measure;
    let svg = over_frames(stretch, measure);
    format!("<figure><figcaption>{title} <span class=\"soft\">({way})</span></figcaption>{svg}</figure>")
}

/// Names of all images of a frame, in their order.
fn images(stretch: &StretchReport) -> Vec<&'static str> {
    ordered(stretch).into_iter().map(|(_, method)| method.numbers.method).chain([REFERENCE]).collect()
}

/// A radio button that looks like a chip.
fn choice(stretch: usize, name: &str, value: &str, text: &str, is_chosen: bool) -> String {
    let checked = if is_chosen { " checked" } else { "" };
    format!(
        "<label><input type=\"radio\" name=\"s{stretch}-{name}\" value=\"{value}\" autocomplete=\"off\"{checked}>\
         <span>{text}</span></label>"
    )
}

fn about(stretch: &StretchReport) -> String {
    let events =
        stretch.events.iter().map(|event| format!("{} at frame {}", escape(&event.label), event.frame));
    let events: Vec<String> = events.collect();
    let events = if events.is_empty() { String::new() } else { format!("; {}", events.join(", ")) };
    let StretchReport { width, height, frames, .. } = stretch;
    format!("{width}×{height} pixels, {frames} frames{events}. From {}.", escape(&stretch.source))
}

/// Which frames the numbers are means of.
fn measured(stretch: &StretchReport) -> String {
    let Some(method) = stretch.methods.first() else { return String::new() };
    let frames: Vec<String> = method.frames.iter().map(|frame| frame.frame.to_string()).collect();
    format!("Means over the {} frames with a reference: {}.", frames.len(), frames.join(", "))
}

fn frame(
    stretch: &StretchReport,
    shown: &ShownFrame,
    pictures: &Pictures,
    is_chosen: bool,
) -> Result<String> {
    let (width, height) = (stretch.width, stretch.height);
    let size = format!("width=\"{width}\" height=\"{height}\"");
    let png = |rgb: &[u8]| Ok::<_, anyhow::Error>(png_source(&png_rgb8(width, height, rgb)?));
    let mut all = String::new();
    for (i, method) in ordered(stretch) {
        let (name, source) = (method.numbers.method, png(&pictures.methods[i])?);
        let (shown_as, numbers) = (label(name), frame_numbers(method, shown.frame));
        let map = png(&pictures.errors.draw(i))?;
        let _ = write!(
            all,
            "<figure><figcaption>{shown_as}<small>{numbers}</small></figcaption>\
             <img class=\"image\" data-image=\"{name}\" data-numbers=\"{numbers}\" alt=\"{shown_as}\" {size} src=\"{source}\">\
             <img class=\"error\" alt=\"error of {shown_as}\" {size} src=\"{map}\"></figure>"
        );
    }
    let legend = legend(pictures.errors.full_scale);
    let source = png(&pictures.reference)?;
    let _ = write!(
        all,
        "<figure><figcaption>reference<small>what all are compared with</small></figcaption>\
         <img class=\"image\" data-image=\"{REFERENCE}\" data-numbers=\"\" alt=\"reference\" {size} src=\"{source}\">{legend}</figure>"
    );
    let strips: String =
        (1..).zip(&shown.crops).map(|(number, crop)| strip(stretch, number, *crop)).collect();
    let hidden = if is_chosen { "" } else { " hidden" };
    Ok(fill(
        include_str!("page/frame.html"),
        &[
            ("frame", shown.frame.to_string()),
            ("label", escape(&shown.label)),
            ("hidden", hidden.to_owned()),
            ("strips", strips),
            ("all", all),
        ],
    ))
}

fn frame_numbers(method: &MethodReport, frame: u32) -> String {
    let found = method.frames.iter().find(|report| report.frame == frame as usize);
    found.map_or(String::new(), |report| {
        let metrics = &report.metrics;
        format!("{:.2} dB, FLIP {:.4}", metrics.psnr_db, metrics.flip)
    })
}

/// The same part of all images; the script draws them.
fn strip(stretch: &StretchReport, number: usize, crop: Rect) -> String {
    let Rect { x, y, width, height } = crop;
    let figures = images(stretch).into_iter().map(|name| {
        format!(
            "<figure><figcaption>{}</figcaption><canvas data-image=\"{name}\" data-x=\"{x}\" data-y=\"{y}\" \
             width=\"{width}\" height=\"{height}\"></canvas></figure>",
            label(name)
        )
    });
    format!(
        "<p class=\"soft\">{number}: {width}×{height} pixels from {x}, {y}</p><div class=\"strip\" data-crop=\"{number}\">{}</div>",
        figures.collect::<String>()
    )
}

fn legend(full_scale: f32) -> String {
    let stops = MAGMA.map(|[r, g, b]| format!("rgb({r} {g} {b})")).join(", ");
    format!(
        "<div class=\"legend\"><div style=\"background: linear-gradient(90deg, {stops})\"></div>\
         <p><span>0</span><span>FLIP error</span><span>≥ {full_scale:.1}</span></p></div>"
    )
}
