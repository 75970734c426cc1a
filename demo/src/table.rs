//! A table that reads well in a terminal and is Markdown.

/// Pads the cells of `rows`, of which the first holds the headings: the first `text_columns` columns to the left, those
/// of numbers to the right.
pub fn aligned(rows: &[Vec<String>], text_columns: usize) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or_default();
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let pad = |(column, cell): (usize, &String)| {
        let width = widths[column];
        if column < text_columns { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
    };
    let rule = |(column, &width): (usize, &usize)| {
        let dashes = "-".repeat(width.saturating_sub(1));
        if column < text_columns { format!("-{dashes}") } else { format!("{dashes}:") }
    };
    let mut lines: Vec<String> =
        rows.iter().map(|row| line(row.iter().enumerate().map(pad).collect())).collect();
    lines.insert(1, line(widths.iter().enumerate().map(rule).collect()));
    lines.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_stands_left_and_numbers_right() {
        let rows = [["method", "ms"], ["a", "12.5"], ["long name", "7"]];
        let rows = rows.map(|row| row.map(str::to_owned).to_vec());
        let expected = "| method    |   ms |\n\
                        | --------- | ---: |\n\
                        | a         | 12.5 |\n\
                        | long name |    7 |\n";
        assert_eq!(aligned(&rows, 1), expected);
    }
}
