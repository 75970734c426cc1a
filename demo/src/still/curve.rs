//! Errors over samples.

use super::Round;
use crate::plot::{Area, LogRange, axis_title, start, x_axis, y_axis};
use std::fmt::Write;

/// True errors of one way of sampling, by the samples that they took.
#[derive(Debug, Clone)]
pub struct Curve {
    pub name: &'static str,
    /// Samples per pixel and relative mean squared error, by samples.
    pub points: Vec<[f64; 2]>,
}

impl Curve {
    /// None without a reference.
    pub fn of(name: &'static str, rounds: &[Round]) -> Option<Self> {
        let points: Vec<[f64; 2]> =
            rounds.iter().filter_map(|round| Some([round.spp, round.relative_mse?])).collect();
        (!points.is_empty()).then_some(Self { name, points })
    }

    /// Samples at which the error is first as low, along straight lines between logarithms.
    fn samples_to(&self, error: f64) -> Option<f64> {
        self.points.windows(2).find_map(|pair| {
            let [[n0, e0], [n1, e1]] = [pair[0], pair[1]];
            (e0 >= error && error >= e1 && e0 > e1).then(|| {
                let share = (e0 / error).ln() / (e0 / e1).ln();
                n0 * (n1 / n0).powf(share)
            })
        })
    }
}

/// How many times the samples of `curve` another one takes to where `curve` ends. None where it does not get there.
pub fn equal_error_ratio(curve: &Curve, other: &Curve) -> Option<f64> {
    let [samples, error] = *curve.points.last()?;
    Some(other.samples_to(error)? / samples)
}

const STYLE: &str = "<style>text{font:14px sans-serif;fill:#333}.frame,.equal{fill:none;stroke:#888}.grid{stroke:#ddd}\
    polyline{fill:none;stroke-width:2}.adaptive,.checkerboard{stroke:#c3423f;fill:#c3423f}.uniform{stroke:#3a6ea5;fill:#3a6ea5}\
    polyline{fill:none!important}text{stroke:none!important}</style>";

/// The curves as an SVG file, both axes logarithmic.
pub fn plot(curves: &[Curve]) -> String {
    let area = Area { left: 74.0, top: 16.0, width: 520.0, height: 340.0 };
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let samples = LogRange::of(all().map(|point| point[0]), 0.0);
    let errors = LogRange::of(all().map(|point| point[1]), 0.0);
    let mut svg = start("Relative mean squared error over samples per pixel", &area).replacen(
        "<svg ",
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"604\" height=\"406\" ",
        1,
    );
    svg += "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>";
    svg += STYLE;
    y_axis(&mut svg, &area, errors.marks(), "relative MSE");
    x_axis(&mut svg, &area, samples.marks());
    axis_title(&mut svg, &area, "samples per pixel");
    for (i, curve) in curves.iter().enumerate() {
        let class = curve.name;
        let at = |&[n, error]: &[f64; 2]| {
            let (x, y) = (samples.place(n), 1.0 - errors.place(error));
            (area.left + x * area.width, area.top + y * area.height)
        };
        let points: Vec<(f64, f64)> = curve.points.iter().map(at).collect();
        let path: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = write!(svg, "<polyline class=\"{class}\" points=\"{}\"/>", path.join(" "));
        for (x, y) in points {
            let _ = write!(svg, "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>");
        }
        let (x, y) = (area.left + area.width - 12.0, area.top + 24.0 + 20.0 * i as f64);
        let _ = write!(svg, "<text class=\"{class}\" x=\"{x}\" y=\"{y}\" text-anchor=\"end\">{class}</text>");
    }
    svg + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[[f64; 2]]) -> Curve {
        Curve { name: "adaptive", points: points.to_vec() }
    }

    #[test]
    fn the_ratio_is_that_of_samples_at_one_error() {
        // Errors go by 1 / n: one that starts at twice the error takes twice the samples.
        let fast = curve(&[[4.0, 0.25], [8.0, 0.125], [16.0, 0.0625]]);
        let slow = curve(&[[4.0, 0.5], [10.0, 0.2], [64.0, 0.03125]]);
        assert!((equal_error_ratio(&fast, &slow).unwrap() - 2.0).abs() < 1e-9);
        assert!((equal_error_ratio(&fast, &fast).unwrap() - 1.0).abs() < 1e-9);
        // What never gets there has none.
        assert_eq!(equal_error_ratio(&fast, &curve(&[[4.0, 0.5], [64.0, 0.07]])), None);
    }

    #[test]
    fn a_plot_shows_every_point() {
        let svg =
            plot(&[curve(&[[4.0, 0.25], [8.0, 0.125]]), Curve { name: "uniform", points: vec![[4.0, 0.5]] }]);
        assert_eq!(svg.matches("<circle").count(), 3);
        assert!(svg.contains(">adaptive</text>") && svg.contains(">uniform</text>"));
    }
}
