//! The page's tables.

use super::columns::{COLUMNS, Column};
use super::numbers::{Margin, MethodNumbers, StretchReport, SuiteReport, is_denoiser, label};
use crate::html::escape;
use crate::method::Method;
use std::fmt::Write;

fn headings(first: &str) -> String {
    let heading = |column: &Column| {
        let unit = if column.unit.is_empty() { String::new() } else { format!(", {}", column.unit) };
        let way = if column.higher_is_better { "↑ higher is better" } else { "↓ lower is better" };
        format!("<th>{}{unit}<small>{way}</small></th>", column.title)
    };
    format!("<tr><th>{first}</th>{}</tr>", COLUMNS.iter().map(heading).collect::<String>())
}

fn scrolled(table: &str) -> String {
    format!("<div class=\"scroll\"><table>{table}</table></div>")
}

/// One row per method; the best denoiser of each column is bold, and quell marked where another one is better.
pub fn methods<'a>(rows: impl Iterator<Item = &'a MethodNumbers> + Clone) -> String {
    let mut out = headings("method");
    let best = COLUMNS.each_ref().map(|column| column.best(rows.clone()));
    for row in rows {
        let name = label(row.method);
        let is_ours = row.method == Method::Quell.name();
        let class = if is_ours { " class=\"ours\"" } else { "" };
        let _ = write!(out, "<tr{class}><td>{name}</td>");
        for (column, best) in COLUMNS.iter().zip(&best) {
            let text = column.text(row);
            let is_best = is_denoiser(row.method) && best.as_ref() == Some(&text);
            let class = match (is_best, is_ours && text != "–") {
                (true, _) => " class=\"best\"",
                (false, true) => " class=\"lost\"",
                _ => "",
            };
            let _ = write!(out, "<td{class}>{text}</td>");
        }
        out += "</tr>";
    }
    scrolled(&out)
}

/// By how much quell is better than each other denoiser, over all and on each stretch.
pub fn margins(report: &SuiteReport) -> String {
    let mut out = headings("quell against");
    for Margin { rival, stretch, gains, lost } in &report.margins {
        let (class, name) = match stretch {
            None => (" class=\"mean\"", format!("{rival}, mean")),
            Some(stretch) => ("", format!("on {}", escape(stretch))),
        };
        let _ = write!(out, "<tr{class}><td>{name}</td>");
        for column in &COLUMNS {
            let class = if lost.contains(&column.key) { " class=\"lost\"" } else { "" };
            let text = gains.get(column.key).map_or("–".to_owned(), |gain| column.gain_text(*gain));
            let _ = write!(out, "<td{class}>{text}</td>");
        }
        out += "</tr>";
    }
    scrolled(&out)
}

/// At a look: per column the margin over the best rival's mean, and on how many stretches quell is the best.
pub fn tiles(report: &SuiteReport) -> String {
    COLUMNS.iter().filter_map(|column| tile(report, column)).collect()
}

fn tile(report: &SuiteReport, column: &Column) -> Option<String> {
    let of_mean = report.margins.iter().filter(|margin| margin.stretch.is_none());
    let means = of_mean.filter_map(|margin| Some((margin.rival, *margin.gains.get(column.key)?)));
    let (rival, gain) = means.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let is_best_on = |stretch: &&StretchReport| {
        let here = report.margins.iter().filter(|margin| margin.stretch.as_ref() == Some(&stretch.name));
        here.clone().count() > 0 && here.into_iter().all(|margin| !margin.lost.contains(&column.key))
    };
    let all = report.stretches.len();
    let best = report.stretches.iter().filter(is_best_on).count();
    let class = if column.is_loss(gain) { "tile lost" } else { "tile" };
    let unit = if column.unit.is_empty() { String::new() } else { format!(" {}", column.unit) };
    Some(format!(
        "<div class=\"{class}\"><span>{}</span><b>{}{unit}</b><small>against {rival}<br>best on {best} of {all}</small></div>",
        column.title,
        column.gain_text(gain)
    ))
}
