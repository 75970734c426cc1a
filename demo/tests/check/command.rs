//! `quell-demo check` by the built binary.

use crate::binary::{assert_fails, assert_succeeds, demo};
use crate::stretch::{SIZE, Stretch};
use crate::{COLONNADE, mistake};
use quell_demo::capture::{CaptureHeader, CaptureWriter};
use std::path::Path;

/// Writes a capture of the stretch.
fn write(stretch: &Stretch, folder: &Path) {
    let [width, height] = SIZE;
    let header = CaptureHeader { width, height, far: f32::MAX, frame_time_s: 1.0 / 30.0 };
    let mut writer = CaptureWriter::create(folder, header, true).unwrap();
    for (frame, info) in &stretch.frames {
        writer.write_frame(frame, info).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn it_says_what_looks_wrong_and_ends_with_1() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    write(&COLONNADE, folder.path());
    let text = assert_succeeds(&demo(&["check", path]));
    assert!(text.contains("nothing looks wrong in 8 frames"), "{text}");
    assert!(text.contains("could not be told") && text.contains("no emitter was seen"), "{text}");
    let text = assert_succeeds(&demo(&["check", path, "--numbers"]));
    assert!(text.contains("MOTION_BACKWARDS"), "{text}");

    let mut stretch = COLONNADE.clone();
    stretch.inject(mistake("motion backwards"));
    write(&stretch, folder.path());
    let output = demo(&["check", path]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("`motion` seems to point the wrong way"), "{text}");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("inputs look wrong") && message.contains(path), "{message}");
}

#[test]
fn it_takes_captures_with_what_is_needed_and_refuses_others() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    assert_fails(&demo(&["check", path]), 1, &["capture.json"]);
    let mut stretch = COLONNADE.clone();
    for (frame, _) in &mut stretch.frames {
        frame.radiance = frame.combined_radiance();
        (frame.motion_depth, frame.roughness, frame.surface_id) = (None, None, None);
        (frame.emission, frame.samples, frame.hit_distance) = (None, None, None);
        (frame.specular, frame.specular_albedo) = (None, None);
    }
    write(&stretch, folder.path());
    let text = assert_succeeds(&demo(&["check", path]));
    assert!(
        text.contains("nothing looks wrong") && !text.contains("emi"),
        "what was not given is not missed: {text}"
    );
    std::fs::write(folder.path().join("frame_0002.exr"), "no image").unwrap();
    assert_fails(&demo(&["check", path]), 1, &["frame_0002.exr", "OpenEXR"]);
}
