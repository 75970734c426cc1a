//! The table as people read it: markdown; and read back from it, the figures.

use std::collections::BTreeMap;
use std::fmt::Write;

/// By section, row and column.
pub type Figures = BTreeMap<(String, String, String), f64>;

/// A heading, a paragraph and a table.
pub struct Section {
    pub title: String,
    pub prose: String,
    pub columns: Vec<&'static str>,
    /// Name and cells.
    pub rows: Vec<(String, Vec<String>)>,
}

/// Begins the line of a section that names the driver it was made by.
const DRIVER: &str = "Driver: ";

/// Marks a section as made by a driver.
pub fn made_by(driver: &str, prose: &str) -> String {
    format!("{DRIVER}{driver}\n\n{prose}")
}

pub fn render(head: &str, sections: &[Section]) -> String {
    let mut page = format!("{}\n", wrap(head));
    for section in sections {
        let mut table = vec![std::iter::once("").chain(section.columns.iter().copied()).collect::<Vec<_>>()];
        for (name, cells) in &section.rows {
            assert_eq!(cells.len(), section.columns.len(), "{}: {name}", section.title);
            table.push(std::iter::once(name.as_str()).chain(cells.iter().map(String::as_str)).collect());
        }
        let width = |column: usize| table.iter().map(|row| row[column].len()).max().unwrap_or_default();
        let widths: Vec<_> = (0..table[0].len()).map(width).collect();
        write!(page, "\n## {}\n\n{}\n\n", section.title, wrap(&section.prose)).unwrap();
        for (i, row) in table.iter().enumerate() {
            let cell = |(cell, &width): (&&str, &usize)| match cell.parse::<f64>() {
                Ok(_) => format!(" {cell:>width$} |"),
                Err(_) => format!(" {cell:<width$} |"),
            };
            writeln!(page, "|{}", row.iter().zip(&widths).map(cell).collect::<String>()).unwrap();
            if i == 0 {
                let rule = |&width: &usize| format!(" {} |", "-".repeat(width.max(3)));
                writeln!(page, "|{}", widths.iter().map(rule).collect::<String>()).unwrap();
            }
        }
    }
    page
}

/// All cells that are numbers.
pub fn figures(page: &str) -> Figures {
    let mut figures = Figures::new();
    let (mut title, mut columns) = (String::new(), Vec::new());
    for line in page.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            (title, columns) = (heading.to_owned(), Vec::new());
        }
        let Some(row) = line.strip_prefix('|').and_then(|row| row.strip_suffix('|')) else { continue };
        let cells: Vec<_> = row.split('|').map(|cell| cell.trim().to_owned()).collect();
        if columns.is_empty() {
            columns = cells;
            continue;
        }
        for (column, cell) in columns.iter().zip(&cells).skip(1) {
            if let Ok(value) = cell.parse() {
                figures.insert((title.clone(), cells[0].clone(), column.clone()), value);
            }
        }
    }
    figures
}

/// The driver that a table was made with.
pub fn driver(page: &str) -> Option<&str> {
    page.lines().find_map(|line| line.strip_prefix(DRIVER))
}

/// Paragraphs in lines of at most 110 characters; lists stay as they are.
fn wrap(prose: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    for line in prose.lines() {
        lines.push(String::new());
        for word in line.split(' ') {
            let last = lines.last_mut().expect("one was pushed");
            if !last.is_empty() && last.len() + word.len() >= 110 {
                lines.push(word.to_owned());
            } else {
                *last += if last.is_empty() { "" } else { " " };
                *last += word;
            }
        }
    }
    lines.join("\n")
}
