//! Mistakes are named, each on two stretches of the tour; what is right raises nothing, on all of them.

#[path = "../binary/mod.rs"]
mod binary;
mod command;
mod mistakes;
mod stretch;

use mistakes::{Injected, MISTAKES};
use quell::{
    Conventions, DepthEncoding, InputCheck, Mistake, MotionDirection, MotionUnit, NormalEncoding, NormalSpace,
};
use quell_demo::check::conventions;
use quell_demo::walk::WalkOptions;
use std::sync::{LazyLock, Mutex, PoisonError};
use stretch::{GPU, SIZE, Stretch, record};

/// Of all tests here, so that the pass is compiled once.
static CHECK: LazyLock<Mutex<InputCheck>> = LazyLock::new(|| {
    let [width, height] = SIZE;
    Mutex::new(InputCheck::new(&GPU.device, &quell::DenoiserDescriptor::new(width, height)).unwrap())
});

/// What mistakes are done to, with jitter.
static COLONNADE: LazyLock<Stretch> = LazyLock::new(|| record(&stretch::options(5.0, true)));
static REFLECTIONS: LazyLock<Stretch> = LazyLock::new(|| record(&stretch::options(30.0, true)));

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
        // Where only every fourth pixel has a sample, the others say nothing.
        let spp = if start_s == 11.5 { 0.25 } else { 1.0 };
        let stretch = record(&WalkOptions { frames: 6, spp, ..stretch::options(start_s, jitter) });
        let (found, text) = said(&stretch);
        assert_eq!(found, [], "at {start_s} s, jitter {jitter}: {text}");
    }
}

/// Whatever the light does, and though some things move, a camera that stands still tells nothing about motion.
#[test]
fn a_still_camera_is_said_not_to_tell() {
    let mut stretch = record(&WalkOptions { fps: 1e6, ..stretch::options(12.0, false) });
    assert_eq!(said(&stretch).0, []);
    stretch.inject(mistake("motion backwards"));
    let (found, text) = said(&stretch);
    assert_eq!(found, []);
    assert!(text.contains("`motion`: the camera stood still"), "{text}");
}

fn mistake(name: &str) -> &'static Injected {
    MISTAKES.iter().find(|mistake| mistake.name == name).expect("a mistake of that name")
}

/// What is a mistake under one convention is right under another.
#[test]
fn nothing_is_raised_by_conventions_that_fit() {
    let right = conventions();
    let cases: [(&str, Conventions); 8] = [
        ("motion backwards", right.with_motion_direction(MotionDirection::FromPrevious)),
        ("motion in UV", right.with_motion_unit(MotionUnit::Uv)),
        ("jitter in motion", right.with_motion_is_jittered(true)),
        ("normals in view space", right.with_normal_space(NormalSpace::View)),
        ("normals packed", right.with_normal_encoding(NormalEncoding::Unsigned)),
        ("hardware depth of the projection", right.with_depth(DepthEncoding::Hardware)),
        ("depth along the ray", right.with_depth(DepthEncoding::Distance)),
        ("nothing", right),
    ];
    for (name, conventions) in cases {
        let mut stretch = COLONNADE.clone();
        if name != "nothing" {
            stretch.inject(mistake(name));
        }
        stretch.conventions = conventions;
        let (found, text) = said(&stretch);
        assert_eq!(found, [], "{name}: {text}");
    }
}

#[test]
fn conventions_that_do_not_fit_are_named() {
    let right = conventions();
    let cases = [
        ("motion", Mistake::MotionSign, right.with_motion_direction(MotionDirection::FromPrevious)),
        ("motion", Mistake::MotionScale, right.with_motion_unit(MotionUnit::Uv)),
        ("motion", Mistake::JitterInMotion, right.with_motion_is_jittered(true)),
        ("normal_roughness", Mistake::NormalsInWorldSpace, right.with_normal_space(NormalSpace::View)),
        ("normal_roughness", Mistake::NormalEncoding, right.with_normal_encoding(NormalEncoding::Unsigned)),
        ("depth", Mistake::DepthLinear, right.with_depth(DepthEncoding::Hardware)),
        ("depth", Mistake::DepthLinear, right.with_depth(DepthEncoding::Distance)),
    ];
    for (name, stretch) in [("colonnade", &COLONNADE), ("reflections", &REFLECTIONS)] {
        let mut stretch = Stretch::clone(stretch);
        for (input, mistake, conventions) in cases {
            stretch.conventions = conventions;
            let (found, text) = said(&stretch);
            assert_eq!(found, [(input, mistake)], "{name}: {conventions:?}: {text}");
        }
    }
}

#[test]
fn every_mistake_is_named_on_two_stretches() {
    let stretches = [("colonnade", &COLONNADE), ("reflections", &REFLECTIONS)];
    let mut wrong = String::new();
    for mistake in &MISTAKES {
        for (name, stretch) in &stretches {
            if !mistake.on.contains(name) {
                continue;
            }
            let mut stretch = Stretch::clone(stretch);
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
