//! Whether the figures of today are no worse than those checked in.

use crate::table::{Figures, driver, figures};
use std::fmt;

/// What may grow without a word.
const TOLERANCE: f64 = 0.1;

/// Sections of which a driver's version decides.
pub const DRIVER_SECTION: &str = "Driver";
/// Sections that follow from the others.
pub const ESTIMATE_SECTION: &str = "Estimate";

/// Something that makes the test fail.
#[derive(Debug, Clone, PartialEq)]
pub enum Problem {
    Spill { figure: Name, now: f64 },
    Worse { figure: Name, before: f64, now: f64 },
    New { figure: Name },
    Missing { figure: Name },
}

/// Section, row, column.
pub type Name = (String, String, String);

#[derive(Debug, Default)]
pub struct Verdict {
    pub problems: Vec<Problem>,
    /// Figures that are better by as much as would be a problem if they were worse.
    pub better: Vec<String>,
    /// Said where figures of drivers were not compared.
    pub skipped: Option<String>,
}

/// Compares two tables, as markdown.
pub fn compare(before: &str, now: &str) -> Verdict {
    let mut verdict = Verdict::default();
    let (old, new) = (figures(before), figures(now));
    let drivers = [driver(before), driver(now)];
    let same_driver = drivers[0] == drivers[1];
    if !same_driver {
        let [before, now] = drivers.map(|driver| driver.unwrap_or("none"));
        verdict.skipped = Some(format!(
            "figures of the driver were not compared but for spills: the table is of {before}, here is {now}"
        ));
    }
    let compared = |name: &Name| {
        !name.0.starts_with(ESTIMATE_SECTION) && (same_driver || !name.0.starts_with(DRIVER_SECTION))
    };
    verdict.problems.extend(spills(&new));
    for (name, &value) in new.iter().filter(|(name, _)| compared(name)) {
        match old.get(name) {
            None => verdict.problems.push(Problem::New { figure: name.clone() }),
            Some(&was) if worse(name, was, value) => {
                verdict.problems.push(Problem::Worse { figure: name.clone(), before: was, now: value });
            }
            Some(&was) if worse(name, value, was) => {
                verdict.better.push(format!("{}: {was} before, {value} now", Shown(name)));
            }
            Some(_) => {}
        }
    }
    let gone = old.keys().filter(|name| compared(name) && !new.contains_key(*name));
    verdict.problems.extend(gone.map(|name| Problem::Missing { figure: name.clone() }));
    verdict
}

fn spills(new: &Figures) -> impl Iterator<Item = Problem> {
    let spilled = new.iter().filter(|((_, _, column), now)| column.starts_with("spilled") && **now > 0.0);
    spilled.map(|(name, &now)| Problem::Spill { figure: name.clone(), now })
}

fn worse(name: &Name, before: f64, now: f64) -> bool {
    // Of occupancy, more is better.
    let (least, most) = if name.2 == "occupancy" { (now, before) } else { (before, now) };
    most > least * (1.0 + TOLERANCE) + 1e-9
}

struct Shown<'a>(&'a Name);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (section, row, column) = self.0;
        write!(f, "{row}, {column} ({section})")
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spill { figure, now } => write!(f, "{}: {now}, registers spill", Shown(figure)),
            Self::Worse { figure, before, now } => {
                let percent = 100.0 * (now / before - 1.0);
                write!(f, "{}: {before} before, {now} now ({percent:+.0} %)", Shown(figure))
            }
            Self::New { figure } => write!(f, "{}: not in the table", Shown(figure)),
            Self::Missing { figure } => write!(f, "{}: in the table, but no longer found", Shown(figure)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "\
# Cost

## Traffic

|         | total | of what |
| ------- | ----- | ------- |
| gains   |    20 | a image |
| compose |    40 |         |

## Driver: navi21

Driver: Mesa 1.2.3

|         | VGPRs | spilled VGPRs |      occupancy |
| ------- | ----- | ------------- | -------------- |
| gains   |    50 |             0 |             10 |

## Estimate: a GPU

|         | ms |
| ------- | -- |
| gains   |  1 |
";

    fn problems(from: &str, to: &str) -> Vec<Problem> {
        assert!(TABLE.contains(from), "{from}");
        compare(TABLE, &TABLE.replace(from, to)).problems
    }

    fn name(section: &str, row: &str, column: &str) -> Name {
        (section.into(), row.into(), column.into())
    }

    #[test]
    fn a_table_equals_itself() {
        let verdict = compare(TABLE, TABLE);
        assert!(verdict.problems.is_empty() && verdict.better.is_empty() && verdict.skipped.is_none());
        assert_eq!(figures(TABLE).len(), 6);
    }

    #[test]
    fn eleven_percent_more_bytes_fail_and_ten_do_not() {
        let figure = name("Traffic", "gains", "total");
        assert_eq!(problems("20", "22.2"), [Problem::Worse { figure, before: 20.0, now: 22.2 }]);
        assert_eq!(problems("20", "22"), []);
    }

    #[test]
    fn growth_from_nothing_fails() {
        let table = TABLE.replace("20", "0");
        assert!(matches!(compare(&table, TABLE).problems.as_slice(), [Problem::Worse { .. }]));
    }

    #[test]
    fn less_is_fine_and_said() {
        let verdict = compare(TABLE, &TABLE.replace("40", "30"));
        assert_eq!(verdict.problems, []);
        assert_eq!(verdict.better, ["compose, total (Traffic): 40 before, 30 now"]);
    }

    #[test]
    fn a_spill_fails_with_any_driver_and_though_the_table_has_it() {
        let spilled = TABLE.replace("|             0 |", "|             3 |");
        let figure = name("Driver: navi21", "gains", "spilled VGPRs");
        let spill = Problem::Spill { figure, now: 3.0 };
        assert!(compare(TABLE, &spilled).problems.contains(&spill));
        assert_eq!(compare(&spilled, &spilled).problems, std::slice::from_ref(&spill));
        let other_driver = spilled.replace("Mesa 1.2.3", "Mesa 4.5.6");
        assert_eq!(compare(TABLE, &other_driver).problems, [spill]);
    }

    #[test]
    fn lower_occupancy_fails() {
        assert!(matches!(problems("10 |", "8 |").as_slice(), [Problem::Worse { now: 8.0, .. }]));
        assert_eq!(problems("10 |", "16 |"), []);
    }

    #[test]
    fn registers_of_another_driver_are_not_compared() {
        let more = TABLE.replace("50", "90");
        assert_eq!(compare(TABLE, &more).problems.len(), 1);
        let verdict = compare(TABLE, &more.replace("Mesa 1.2.3", "Mesa 4.5.6"));
        assert_eq!(verdict.problems, []);
        assert!(verdict.skipped.unwrap().contains("Mesa 4.5.6"));
    }

    #[test]
    fn missing_and_new_passes_fail() {
        let figure = name("Traffic", "compose", "total");
        assert_eq!(
            problems("| compose |    40 |         |\n", ""),
            [Problem::Missing { figure: figure.clone() }]
        );
        let without = TABLE.replace("| compose |    40 |         |\n", "");
        assert_eq!(compare(&without, TABLE).problems, [Problem::New { figure }]);
    }

    #[test]
    fn a_missing_section_fails() {
        let without = TABLE.split("## Driver").next().unwrap().to_owned() + "Driver: Mesa 1.2.3\n";
        assert_eq!(compare(TABLE, &without).problems.len(), 3);
    }

    #[test]
    fn estimates_are_not_compared() {
        assert_eq!(problems("|  1 |", "|  9 |"), []);
    }

    #[test]
    fn a_problem_names_pass_figure_before_and_now() {
        let [problem] = problems("20", "30").try_into().unwrap();
        assert_eq!(problem.to_string(), "gains, total (Traffic): 20 before, 30 now (+50 %)");
    }
}
