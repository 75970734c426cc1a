//! The side panel: what is shown, the denoiser's settings, times.

use super::view_state::{RIVALS, ViewMode, ViewState, rival_name};
use crate::gbuffer::Split;
use crate::tracer::Sampling;
use egui::{Color32, ComboBox, Pos2, Rect, Sense, Slider, Stroke, Ui, Vec2};
use quell::{Budget, Centres, DebugView, Windows};
use std::collections::VecDeque;

/// Frames in the frame-time graph.
pub const GRAPH_FRAMES: usize = 120;
const WIDTH: f32 = 300.0;
const SLIDER_WIDTH: f32 = 90.0;
const GRAPH_HEIGHT: f32 = 60.0;

/// What the panel tells.
#[derive(Debug)]
pub struct PanelInfo<'a> {
    /// Adapter and render size.
    pub device: &'a str,
    /// The source's line, such as the number of models or of reference samples.
    pub status: &'a str,
    /// Label and milliseconds of each pass on the GPU; empty where it cannot be measured.
    pub passes: &'a [(String, f32)],
    /// Seconds from frame to frame, oldest first.
    pub frame_times_s: &'a VecDeque<f32>,
}

/// Draws the panel where it is wanted, and lets it change the view. Returns the rest of the window, in points.
pub fn panel(ui: &mut Ui, view: &mut ViewState, info: &PanelInfo<'_>) -> Rect {
    if view.panel {
        egui::Panel::right("panel").resizable(false).exact_size(WIDTH).show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| contents(ui, view, info));
        });
    }
    ui.available_rect_before_wrap()
}

fn contents(ui: &mut Ui, view: &mut ViewState, info: &PanelInfo<'_>) {
    // What is wider than the panel would lie over the image.
    ui.spacing_mut().slider_width = SLIDER_WIDTH;
    ui.spacing_mut().combo_width = SLIDER_WIDTH;
    ui.heading("quell");
    ui.add(egui::Label::new(egui::RichText::new(info.device).small()).wrap());
    if !info.status.is_empty() {
        ui.label(info.status);
    }
    section(ui, "View", |ui| image_controls(ui, view));
    section(ui, "Time and samples", |ui| time_controls(ui, view));
    section(ui, "Denoiser", |ui| denoiser_controls(ui, view));
    section(ui, "Frame time", |ui| frame_graph(ui, info.frame_times_s));
    section(ui, "Passes on the GPU", |ui| pass_times(ui, info.passes));
    section(ui, "Keys", keys);
}

fn section(ui: &mut Ui, title: &str, contents: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(title).default_open(true).show(ui, contents);
}

fn image_controls(ui: &mut Ui, view: &mut ViewState) {
    ui.horizontal_wrapped(|ui| {
        for (mode, key) in ViewMode::ALL.into_iter().zip(1..) {
            let name = view.name(mode);
            ui.selectable_value(&mut view.mode, mode, name).on_hover_text(format!("Key {key}"));
        }
    });
    ComboBox::from_label("Rival").selected_text(rival_name(view.rival)).show_ui(ui, |ui| {
        for rival in RIVALS {
            ui.selectable_value(&mut view.rival, rival, rival_name(rival));
        }
    });
    if view.mode == ViewMode::Split {
        let names = ViewMode::IMAGES.map(|image| (image, view.name(image)));
        for (label, side) in ["Left", "Right"].into_iter().zip(&mut view.split_sides) {
            let name = names.iter().find(|(image, _)| image == side).map_or("", |(_, name)| name);
            ComboBox::from_label(label).selected_text(name).show_ui(ui, |ui| {
                for (image, name) in names {
                    ui.selectable_value(side, image, name);
                }
            });
        }
        ui.add(Slider::new(&mut view.split, 0.0..=1.0).text("Line")).on_hover_text("Or drag it in the image");
    }
    let name = |debug: Option<DebugView>| debug.map_or("None".to_owned(), |debug| format!("{debug:?}"));
    ComboBox::from_label("Debug view").selected_text(name(view.debug)).show_ui(ui, |ui| {
        for debug in std::iter::once(None).chain(DebugView::ALL.map(Some)) {
            ui.selectable_value(&mut view.debug, debug, name(debug));
        }
    });
    ui.add(Slider::new(&mut view.exposure_ev, -6.0..=6.0).text("Exposure").suffix(" EV"));
}

fn time_controls(ui: &mut Ui, view: &mut ViewState) {
    ui.horizontal(|ui| {
        ui.toggle_value(&mut view.paused, "Pause");
        if ui.add_enabled(view.paused, egui::Button::new("Step")).clicked() {
            view.step = true;
        }
        if ui.button("Restart").on_hover_text("Drop all history").clicked() {
            view.restart = true;
        }
    });
    ui.toggle_value(&mut view.free_flight, "Free flight");
    ui.add(Slider::new(&mut view.spp, 0.25..=16.0).logarithmic(true).text("Samples per pixel"));
    const SAMPLING: [(Sampling, &str); 3] = [
        (Sampling::Uniform, "uniform"),
        (Sampling::Checkerboard, "checkerboard"),
        (Sampling::Adaptive, "adaptive"),
    ];
    choice(ui, "Sampling", &mut view.sampling, &SAMPLING);
}

fn denoiser_controls(ui: &mut Ui, view: &mut ViewState) {
    let mut apart = view.signals != Split::None;
    let described = "Off, reflections are denoised with all else, as if they were painted on the surface";
    if ui.checkbox(&mut apart, "Specular radiance apart").on_hover_text(described).changed() {
        view.toggle_signals();
    }
    let settings = &mut view.settings;
    ui.add(Slider::new(&mut settings.max_history, 1.0..=1024.0).logarithmic(true).integer().text("History"))
        .on_hover_text("Higher keeps more detail and less noise; lower follows changes of the light sooner");
    const WINDOWS: [(Windows, &str); 5] = [
        (Windows::MallowsCp, "by Mallows' Cp"),
        (Windows::RingError, "by ring error"),
        (Windows::Fixed(1), "five tiles"),
        (Windows::Fixed(2), "3x3 tiles"),
        (Windows::Fixed(3), "5x5 tiles"),
    ];
    const CENTRES: [(Centres, &str); 4] = [
        (Centres::Adaptive, "adaptive"),
        (Centres::Uniform(1), "every 8 pixels"),
        (Centres::Uniform(2), "every 16 pixels"),
        (Centres::Uniform(4), "every 32 pixels"),
    ];
    choice(ui, "Windows", &mut settings.windows, &WINDOWS);
    choice(ui, "Centres", &mut settings.centres, &CENTRES);
    budget_controls(ui, &mut settings.budget);
    let all = quell::SAVINGS.len() as u32;
    ui.add(Slider::new(&mut settings.savings, 0..=all).text("Savings"))
        .on_hover_text(quell::SAVINGS.join(", "));
    if matches!(settings.budget, Budget::Milliseconds(_)) {
        ui.add(Slider::new(&mut settings.most_savings, 0..=all).text("Most savings"))
            .on_hover_text("To keep the time");
    }
    ui.add(Slider::new(&mut settings.firefly_limit, 0.1..=100.0).logarithmic(true).text("Firefly limit"))
        .on_hover_text("Standard errors by which one sample may move its neighbourhood's mean");
    ui.checkbox(&mut settings.innovation, "Predict changes of the light")
        .on_hover_text("Off, a light that was switched fades over the length of the history");
    ui.checkbox(&mut settings.mix_temporal_mean, "Mix with the temporal mean")
        .on_hover_text("Off shows the models' prediction alone");
    if ui.button("Defaults").clicked() {
        let defaults = quell::Settings::default();
        // The source's own: what it renders decides them.
        *settings = defaults.with_far(settings.far);
    }
}

fn budget_controls(ui: &mut Ui, budget: &mut Budget) {
    const STARTS: [(Budget, &str); 3] = [
        (Budget::Unlimited, "none"),
        (Budget::Models(2000), "of models"),
        (Budget::Milliseconds(4.0), "of time"),
    ];
    let is =
        |budget: &Budget, start: &Budget| std::mem::discriminant(budget) == std::mem::discriminant(start);
    let name = STARTS.iter().find(|(start, _)| is(budget, start)).map_or("", |(_, name)| name);
    ComboBox::from_label("Budget").selected_text(name).show_ui(ui, |ui| {
        for (start, name) in STARTS {
            if ui.selectable_label(is(budget, &start), name).clicked() && !is(budget, &start) {
                *budget = start;
            }
        }
    });
    match budget {
        Budget::Models(most) => {
            ui.add(Slider::new(most, 0..=100_000).logarithmic(true).text("Models"));
        }
        Budget::Milliseconds(target_ms) => {
            ui.add(Slider::new(target_ms, 0.1..=100.0).logarithmic(true).text("Time").suffix(" ms"));
        }
        _ => {}
    }
}

fn choice<T: Copy + PartialEq>(ui: &mut Ui, label: &str, value: &mut T, options: &[(T, &str)]) {
    let name = options.iter().find(|(option, _)| option == value).map_or("", |(_, name)| name);
    ComboBox::from_label(label).selected_text(name).show_ui(ui, |ui| {
        for &(option, name) in options {
            ui.selectable_value(value, option, name);
        }
    });
}

fn frame_graph(ui: &mut Ui, times_s: &VecDeque<f32>) {
    let Some(&last) = times_s.back() else {
        return;
    };
    let mean = times_s.iter().sum::<f32>() / times_s.len() as f32;
    ui.label(format!("{:.1} ms ({:.0} fps), mean {:.1} ms", last * 1e3, 1.0 / last.max(1e-6), mean * 1e3));
    let (response, painter) =
        ui.allocate_painter(Vec2::new(ui.available_width(), GRAPH_HEIGHT), Sense::hover());
    let rect = response.rect;
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    // At least two frames of 60 Hz high, so that a steady rate does not fill the graph with its jitter.
    let top = times_s.iter().copied().fold(2.0 / 60.0, f32::max);
    let y = |time: f32| rect.bottom() - rect.height() * (time / top).min(1.0);
    painter.hline(rect.x_range(), y(1.0 / 60.0), Stroke::new(1.0, Color32::DARK_GREEN));
    let x = |i: usize| rect.left() + rect.width() * i as f32 / (GRAPH_FRAMES - 1) as f32;
    let points = times_s.iter().enumerate().map(|(i, &time)| Pos2::new(x(i), y(time))).collect();
    painter.line(points, Stroke::new(1.0, Color32::LIGHT_GREEN));
}

fn pass_times(ui: &mut Ui, passes: &[(String, f32)]) {
    if passes.is_empty() {
        ui.label("per-pass times need a GPU with timestamp queries");
        return;
    }
    egui::Grid::new("passes").striped(true).min_col_width(WIDTH * 0.35).show(ui, |ui| {
        let total = passes.iter().map(|(_, ms)| ms).sum::<f32>();
        for (label, ms) in passes.iter().map(|(label, ms)| (label.as_str(), *ms)).chain([("total", total)]) {
            ui.label(label);
            ui.monospace(format!("{ms:7.3} ms"));
            ui.end_row();
        }
    });
}

/// Key and what it does, as the window handles them.
const KEYS: [(&str, &str); 13] = [
    ("1 - 5", "image"),
    ("C", "show or change the rival"),
    ("Space", "pause"),
    ("N", "single step"),
    ("R", "restart"),
    ("L", "specular radiance apart or not"),
    ("F", "path or free flight"),
    ("W A S D Q E", "fly"),
    ("Shift", "fly faster"),
    ("right button", "look around"),
    ("M", "hold the mouse to look"),
    ("Tab, H", "this panel"),
    ("Esc", "quit"),
];

fn keys(ui: &mut Ui) {
    egui::Grid::new("keys").show(ui, |ui| {
        for (key, effect) in KEYS {
            ui.strong(key);
            ui.label(effect);
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lays the panel out without a window; returns the width that is left for the image.
    fn laid_out(view: &mut ViewState, passes: &[(String, f32)]) -> f32 {
        let context = egui::Context::default();
        let times = VecDeque::from(vec![0.016; GRAPH_FRAMES]);
        let info = PanelInfo { device: "CPU", status: "", passes, frame_times_s: &times };
        let screen = Rect::from_min_size(Pos2::ZERO, Vec2::new(1000.0, 800.0));
        let mut rest = screen;
        for _ in 0..2 {
            let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
            let output = context.run_ui(input, |ui| rest = panel(ui, view, &info));
            assert!(!view.panel || !output.shapes.is_empty());
            output.drop_without_applying_deltas();
        }
        rest.width()
    }

    #[test]
    fn the_panel_takes_its_width_only_when_shown() {
        let mut view = ViewState { mode: ViewMode::Split, paused: true, ..ViewState::default() };
        let unchanged = view.clone();
        let rest = laid_out(&mut view, &[("fit".to_owned(), 1.5)]);
        // Exactly: contents that are too wide would push the panel over the image.
        assert!((rest - (1000.0 - WIDTH)).abs() < 1.0, "{rest}");
        assert_eq!(view, unchanged, "showing it changes nothing");
        view.panel = false;
        assert_eq!(laid_out(&mut view, &[]), 1000.0);
    }
}
