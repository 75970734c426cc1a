//! Mistakes are named, each on two stretches of the tour; what is right raises nothing, on all of them.

mod mistakes;
mod stretch;

use mistakes::MISTAKES;
use quell::{InputCheck, Mistake};
use quell_demo::walk::WalkOptions;
use std::sync::{LazyLock, Mutex, PoisonError};
use stretch::{GPU, SIZE, Stretch, record};

/// Of all tests here, so that the pass is compiled once.
static CHECK: LazyLock<Mutex<InputCheck>> = LazyLock::new(|| {
    let [width, height] = SIZE;
    Mutex::new(InputCheck::new(&GPU.device, &quell::DenoiserDescriptor::new(width, height)).unwrap())
});

/// What is said of a stretch: the inputs and what is wrong with them, and all of it as text, with what is not told.
fn said(stretch: &Stretch) -> (Vec<(&'static str, Mistake)>, String) {
    let mut check = CHECK.lock().unwrap_or_else(PoisonError::into_inner);
    check.clear();
    stretch.check(&mut check);
    let found = check.findings();
    let sentences: String = found.iter().map(|finding| format!("{finding}\n")).collect();
    let untold: String = check.untold().iter().map(|untold| format!("{untold}\n")).collect();
    let pairs = found.iter().map(|finding| (finding.input, finding.mistake)).collect();
    (pairs, format!("{sentences}{untold}{}", check.evidence()))
}

#[test]
fn nothing_is_raised_by_what_is_right() {
    // Seconds into the tour: outdoors, hall, lamp, dim room, back; from 24 on reflections; every other one with jitter.
    let starts_s = [0.0, 3.0, 6.0, 9.0, 11.5, 16.0, 20.0, 23.9, 26.0, 29.0, 33.0];
    for (i, start_s) in starts_s.into_iter().enumerate() {
        let jitter = i % 2 == 1;
        let stretch = record(&WalkOptions { frames: 6, ..stretch::options(start_s, jitter) });
        let (found, text) = said(&stretch);
        assert_eq!(found, [], "at {start_s} s, jitter {jitter}: {text}");
    }
}

/// Whatever the light does, and though some things move, a camera that stands still tells nothing about motion.
#[test]
fn a_still_camera_is_said_not_to_tell() {
    let mut stretch = record(&WalkOptions { fps: 1e6, ..stretch::options(12.0, false) });
    assert_eq!(said(&stretch).0, []);
    stretch.inject(MISTAKES.iter().find(|mistake| mistake.name == "motion backwards").unwrap());
    let (found, text) = said(&stretch);
    assert_eq!(found, []);
    assert!(text.contains("`motion`: the camera stood still"), "{text}");
}

#[test]
fn every_mistake_is_named_on_two_stretches() {
    let stretches = [
        ("colonnade", record(&stretch::options(5.0, true))),
        ("reflections", record(&stretch::options(30.0, true))),
    ];
    let mut wrong = String::new();
    for mistake in &MISTAKES {
        for (name, stretch) in &stretches {
            if !mistake.on.contains(name) {
                continue;
            }
            let mut stretch = stretch.clone();
            stretch.inject(mistake);
            let (found, text) = said(&stretch);
            println!("{name}: {}: {}", mistake.name, text.lines().next().unwrap());
            if found != [(mistake.input, mistake.mistake)] {
                wrong += &format!("{name}: {}: {found:?}\n{text}\n", mistake.name);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
