//! The page: `measure.html`.

use super::growth::points;
use super::pace::Pace;
use super::views::Views;
use super::{BenchReport, MeasureReport};
use crate::bench::percentiles::Percentiles;
use crate::bench::report::MethodReport;
use crate::html::{escape, fill};
use crate::plot::{Area, LogRange, axis_title, start, x_axis, y_axis};
use std::fmt::Write;

/// Of methods or budgets, in order.
const COLOURS: [&str; 6] = ["#c3423f", "#3a6ea5", "#4b8b4f", "#8a6fb0", "#b0803a", "#5d6670"];
const AREA: Area = Area { left: 64.0, top: 10.0, width: 480.0, height: 300.0 };
const WIDE_AREA: Area = Area { width: 1060.0, ..AREA };

pub fn page(report: &MeasureReport) -> String {
    let MeasureReport { machine, walk, still, cut, paces, .. } = report;
    let power = ["before", "after"]
        .iter()
        .zip(&report.power)
        .filter_map(|(when, state)| Some(format!("clocks and power {when}:\n{}", state.as_ref()?)));
    let power: Vec<String> = power.collect();
    let power = if power.is_empty() {
        "The driver tells nothing of clocks and power.".to_owned()
    } else {
        power.join("\n")
    };
    // All sizes have the same.
    let methods = walk.sizes.first().map_or(&[][..], |size| &size.methods);
    let methods: Vec<&str> = methods.iter().map(|found| found.method).collect();
    let over_pixels =
        |title: &str, value: fn(&MethodReport) -> f64| over_pixels(walk, &methods, title, value);
    let values = [
        ("adapter", escape(&machine.adapter)),
        ("machine", escape(&machine.to_string())),
        (
            "note",
            escape(walk.note.unwrap_or(
                "Times are of the GPU's timestamps, from the begin of the first pass to the end of the last.",
            )),
        ),
        ("power", escape(&power)),
        ("growth", escape(&report.growth.to_string())),
        ("method_keys", keys(methods.iter().map(|name| (*name).to_owned()))),
        ("time_plot", over_pixels("milliseconds", |found| found.frame_ms.median)),
        ("memory_plot", over_pixels("megabytes", |found| found.memory.total_bytes as f64 * 1e-6)),
        ("frames", table(&walk.frames_table())),
        ("passes", table(&walk.passes_table())),
        ("still", table(&still.frames_table())),
        ("still_passes", table(&still.passes_table())),
        ("cut", table(&cut.frames_table())),
        ("cut_passes", table(&cut.passes_table())),
        ("at", format!("{}x{}", report.at[0], report.at[1])),
        ("views", table(&views_table(&report.views))),
        ("pace_keys", keys(paces.iter().map(|pace| format!("{} ms", pace.target_ms)))),
        ("pace_plot", pace_plot(paces)),
        ("paces", table(&pace_table(paces))),
    ];
    fill(include_str!("page.html"), &values)
}

fn colour(i: usize) -> &'static str {
    COLOURS[i % COLOURS.len()]
}

fn keys(names: impl Iterator<Item = String>) -> String {
    let key = |(i, name): (usize, String)| {
        format!("<span><i style=\"background:{}\"></i>{}</span>", colour(i), escape(&name))
    };
    names.enumerate().map(key).collect()
}

/// The first row has the headings; none without others.
fn table(rows: &[Vec<String>]) -> String {
    let row = |cells: &Vec<String>, tag: &str| {
        let cells: String = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell))).collect();
        format!("<tr>{cells}</tr>")
    };
    match rows {
        [headings, rows @ ..] if !rows.is_empty() => {
            let rows: String = rows.iter().map(|cells| row(cells, "td")).collect();
            format!("<table>{}{rows}</table>", row(headings, "th"))
        }
        _ => String::new(),
    }
}

/// A curve per method, both axes logarithmic.
fn over_pixels(
    report: &BenchReport,
    methods: &[&str],
    title: &str,
    value: fn(&MethodReport) -> f64,
) -> String {
    let curves: Vec<Vec<[f64; 2]>> = methods.iter().map(|method| points(report, method, value)).collect();
    let range = |axis: usize| LogRange::of(curves.iter().flatten().map(|point| point[axis]), 0.0);
    let (pixels, values) = (range(0), range(1));
    let mut svg = start(&format!("{title} over pixels"), &AREA);
    y_axis(&mut svg, &AREA, values.marks(), title);
    x_axis(&mut svg, &AREA, pixels.marks());
    axis_title(&mut svg, &AREA, "pixels");
    for (i, curve) in curves.iter().enumerate() {
        curve_of(&mut svg, &AREA, i, curve.iter().map(|&[x, y]| [pixels.place(x), values.place(y)]));
    }
    svg + "</svg>"
}

/// Times over frames, and the budgets. With room for twice the largest budget and for what frames come to at last, no more: first
/// frames that compile take longer.
fn pace_plot(paces: &[Pace]) -> String {
    let needed = |pace: &Pace| (2.0 * f64::from(pace.target_ms)).max(1.2 * pace.settled_ms.p95);
    let most = paces.iter().map(needed).fold(0.0, f64::max);
    let decimals = if most < 10.0 { 2 } else { 0 };
    let frames = paces.iter().map(|pace| pace.frame_ms.len()).max().unwrap_or_default().max(2);
    let mut svg = start("Milliseconds over frames", &WIDE_AREA);
    let fifths = || (0..=5).map(|i| f64::from(i) / 5.0);
    y_axis(
        &mut svg,
        &WIDE_AREA,
        fifths().map(|place| (place, format!("{:.decimals$}", place * most))),
        "milliseconds",
    );
    x_axis(
        &mut svg,
        &WIDE_AREA,
        fifths().map(|place| (place, format!("{:.0}", place * (frames - 1) as f64))),
    );
    axis_title(&mut svg, &WIDE_AREA, "frame");
    for (i, pace) in paces.iter().enumerate() {
        let place = |ms: f64| (ms / most).clamp(0.0, 1.0);
        let at = |(frame, &ms): (usize, &f64)| [frame as f64 / (frames - 1) as f64, place(ms)];
        curve_of(&mut svg, &WIDE_AREA, i, pace.frame_ms.iter().enumerate().map(at));
        let Area { left, top, width, height } = WIDE_AREA;
        let y = top + (1.0 - place(f64::from(pace.target_ms))) * height;
        let (right, colour) = (left + width, colour(i));
        let _ = write!(
            svg,
            "<line class=\"target\" stroke=\"{colour}\" x1=\"{left}\" y1=\"{y:.1}\" x2=\"{right}\" y2=\"{y:.1}\"/>"
        );
    }
    svg + "</svg>"
}

/// Places from 0 to 1.
fn curve_of(svg: &mut String, area: &Area, i: usize, places: impl Iterator<Item = [f64; 2]>) {
    let at = |[x, y]: [f64; 2]| {
        format!("{:.1},{:.1}", area.left + x * area.width, area.top + (1.0 - y) * area.height)
    };
    let points: Vec<String> = places.map(at).collect();
    let _ = write!(svg, "<polyline stroke=\"{}\" points=\"{}\"/>", colour(i), points.join(" "));
}

fn views_table(views: &[Views]) -> Vec<Vec<String>> {
    let headings = ["views", "median ms", "p95", "over one view's", "MB"];
    let row = |found: &Views| {
        let Views { views: count, frame_ms: Percentiles { median, p95, .. }, memory_bytes } = found;
        let ratio = views.first().map_or(f64::NAN, |one| median / one.frame_ms.median);
        let megabytes = *memory_bytes as f64 * 1e-6;
        vec![
            count.to_string(),
            format!("{median:.3}"),
            format!("{p95:.3}"),
            format!("{ratio:.2}"),
            format!("{megabytes:.2}"),
        ]
    };
    std::iter::once(headings.map(str::to_owned).to_vec()).chain(views.iter().map(row)).collect()
}

fn pace_table(paces: &[Pace]) -> Vec<Vec<String>> {
    let headings = ["budget, ms", "kept", "models at last", "median ms", "p95"];
    let row = |pace: &Pace| {
        let kept = pace.settled_after.map_or("no".to_owned(), |frames| format!("after {frames} frames"));
        let models =
            pace.models.last().copied().flatten().map_or("-".to_owned(), |models| models.to_string());
        let times = [pace.settled_ms.median, pace.settled_ms.p95].map(|ms| format!("{ms:.3}"));
        [vec![pace.target_ms.to_string(), kept, models], times.to_vec()].concat()
    };
    std::iter::once(headings.map(str::to_owned).to_vec()).chain(paces.iter().map(row)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_headings_and_cells_that_are_text() {
        let rows = [["a", "b"], ["<1>", "2"]].map(|row| row.map(str::to_owned).to_vec());
        assert_eq!(
            table(&rows),
            "<table><tr><th>a</th><th>b</th></tr><tr><td>&lt;1&gt;</td><td>2</td></tr></table>"
        );
        assert_eq!(table(&rows[..1]), "", "headings alone say nothing");
    }

    #[test]
    fn views_are_compared_with_one() {
        let of = |views, ms, memory_bytes| Views { views, frame_ms: Percentiles::of(&[ms]), memory_bytes };
        let rows = views_table(&[of(1, 2.0, 3_000_000), of(4, 7.0, 12_500_000)]);
        assert_eq!(rows[2], ["4", "7.000", "7.000", "3.50", "12.50"]);
    }

    #[test]
    fn times_beyond_the_plot_stay_at_its_edge() {
        let pace = Pace {
            target_ms: 1.0,
            frame_ms: vec![50.0, 1.0],
            models: vec![None, Some(7)],
            settled_ms: Percentiles::of(&[1.0]),
            settled_after: Some(1),
        };
        let svg = pace_plot(std::slice::from_ref(&pace));
        assert!(svg.contains("points=\"64.0,10.0 1124.0,160.0\""), "{svg}");
        assert_eq!(pace_table(&[pace])[1], ["1", "after 1 frames", "7", "1.000", "1.000"]);
    }
}
