//! What changes a sequence at once, and which frames show it.

use crate::scene::{Interpolation, Scene};
use serde::Serialize;

/// A change from one frame to the next.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Event {
    /// The first frame that shows it.
    pub frame: u32,
    pub label: String,
}

/// The lights that go on or off between two of the `times_s` of successive frames.
pub fn light_switches(scene: &Scene, times_s: &[f32]) -> Vec<Event> {
    let lights = scene.materials.iter().filter_map(|material| {
        let track = material.emission_scale.as_ref()?;
        (track.interpolation == Interpolation::Step).then_some((material.name.as_str(), track))
    });
    let mut events = Vec::new();
    for (pair, frame) in times_s.windows(2).zip(1..) {
        for (name, track) in lights.clone() {
            let label = match (track.at(pair[0]), track.at(pair[1])) {
                (before, after) if before == after => continue,
                (_, 0.0) => format!("{name} off"),
                (0.0, _) => format!("{name} on"),
                _ => format!("{name} changes"),
            };
            events.push(Event { frame, label });
        }
    }
    events
}

/// Which of the `measured` frames (ascending) are worth to look at, and what each is: those about the first events, or the
/// `hardest` where there are none, and the last.
pub fn telling_frames(measured: &[u32], events: &[Event], hardest: Option<u32>) -> Vec<(u32, String)> {
    /// More would make the page large.
    const EVENTS: usize = 2;
    let mut chosen: Vec<(u32, String)> = Vec::new();
    let mut add = |frame: Option<&u32>, label: String| {
        if let Some(&frame) = frame.filter(|&&frame| chosen.iter().all(|(other, _)| *other != frame)) {
            chosen.push((frame, label));
        }
    };
    for Event { frame, label } in events.iter().take(EVENTS) {
        add(measured.iter().rfind(|measured| *measured < frame), format!("before {label}"));
        let after = measured.iter().find(|measured| *measured >= frame);
        add(after, after.map_or(String::new(), |after| since(after - frame, label)));
    }
    let before_last = measured.last().and_then(|last| events.iter().rfind(|event| event.frame <= *last));
    let label = match (measured.last(), before_last) {
        (Some(last), Some(event)) => since(last - event.frame, &event.label),
        _ => "last".to_owned(),
    };
    add(measured.last(), label);
    if events.is_empty() {
        add(hardest.as_ref(), "the hardest".to_owned());
    }
    chosen.sort_unstable();
    chosen
}

fn since(frames: u32, label: &str) -> String {
    match frames {
        0 => label.to_owned(),
        1 => format!("1 frame after {label}"),
        frames => format!("{frames} frames after {label}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::gallery::gallery;

    #[test]
    fn the_gallerys_lamp_is_seen_to_switch() {
        // On for 3.5 of every 6 seconds.
        let times: Vec<f32> = (0..80).map(|i| i as f32 * 0.1).collect();
        let event = |frame, label: &str| Event { frame, label: label.to_owned() };
        let mut found = light_switches(&gallery(), &times);
        // 35 * 0.1 and 60 * 0.1 may round to either side.
        for (event, exact) in found.iter_mut().zip([35, 60]) {
            assert!(event.frame.abs_diff(exact) <= 1, "{event:?}");
            event.frame = exact;
        }
        assert_eq!(found, [event(35, "lamp off"), event(60, "lamp on")]);
        assert!(light_switches(&gallery(), &[1.0, 2.0, 3.0]).is_empty());
    }

    #[test]
    fn frames_about_an_event_are_told() {
        let off = Event { frame: 7, label: "lamp off".to_owned() };
        let found = |measured: &[u32], events: &[Event]| -> Vec<String> {
            let frames = telling_frames(measured, events, Some(2)).into_iter();
            frames.map(|(frame, label)| format!("{frame}: {label}")).collect()
        };
        let all = ["6: before lamp off", "7: lamp off", "11: 4 frames after lamp off"];
        assert_eq!(found(&[0, 1, 5, 6, 7, 8, 10, 11], std::slice::from_ref(&off)), all);
        assert_eq!(
            found(&[2, 8], std::slice::from_ref(&off)),
            ["2: before lamp off", "8: 1 frame after lamp off"]
        );
        assert_eq!(found(&[2, 3], &[off]), ["3: before lamp off"]);
        assert_eq!(found(&[2, 3], &[]), ["2: the hardest", "3: last"]);
        assert_eq!(found(&[1, 2], &[]), ["2: last"]);
        assert!(telling_frames(&[], &[], None).is_empty());
    }
}
