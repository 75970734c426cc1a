//! The harness catches what it is for: each of these cases is a bad loader.

use crate::files::{load_scene, temporary};
use crate::harness::{Failure, Limits, run};
use crate::oracle::{check_error, check_scene};
use crate::seeds;
use image::ImageFormat;
use std::path::Path;
use std::time::{Duration, Instant};

const SHORT: Limits = Limits { time: Duration::from_millis(300), memory: 1 << 20 };
/// Enough on a busy machine.
const LONG: Limits = Limits { time: Duration::from_secs(60), memory: 1 << 20 };

#[test]
fn a_good_case_passes() {
    assert_eq!(run(LONG, 0, || Ok(())), Ok(()));
}

#[test]
fn a_panic_is_caught() {
    let empty: Vec<u8> = Vec::new();
    let result = run(LONG, 0, move || Err(format!("{}", empty[std::hint::black_box(3)])));
    assert!(matches!(&result, Err(Failure::Panic(text)) if text.contains("harness_tests.rs")), "{result:?}");
}

#[test]
fn a_panic_that_the_loader_catches_is_caught_too() {
    let result = run(LONG, 0, || {
        let _ = std::panic::catch_unwind(|| panic!("swallowed"));
        Ok(())
    });
    assert!(matches!(&result, Err(Failure::Panic(text)) if text.contains("swallowed")), "{result:?}");
}

#[cfg(unix)]
#[test]
fn a_hang_is_caught() {
    let temporary = temporary();
    let pipe = temporary.place.inside.join("pipe");
    let start = Instant::now();
    // What a loader does that opens whatever it is told to.
    let result = run(SHORT, 0, move || std::fs::read(pipe).map(drop).map_err(|error| error.to_string()));
    assert_eq!(result, Err(Failure::Hang));
    assert!(start.elapsed() < Duration::from_secs(30));
}

#[test]
fn memory_is_bounded_however_it_is_asked_for() {
    let asks: [fn() -> usize; 4] = [
        || std::hint::black_box(vec![0_u8; 2 << 20]).len(),
        || std::hint::black_box(Vec::<u8>::with_capacity(2 << 20)).capacity(),
        || {
            let mut grown = Vec::new();
            (0..1_u32 << 19).for_each(|i| grown.push(i));
            std::hint::black_box(grown).len()
        },
        || {
            let many: Vec<Box<[u8; 1024]>> = (0..2048).map(|_| Box::new([1; 1024])).collect();
            std::hint::black_box(many).len()
        },
    ];
    for ask in asks {
        let result = run(LONG, 0, move || (ask() > 0).then_some(()).ok_or_else(String::new));
        assert!(matches!(result, Err(Failure::Memory { peak }) if peak >= 1 << 20), "{result:?}");
    }
    // What is given back in time does not add up.
    let in_turn = || {
        (0..100).for_each(|_| drop(std::hint::black_box(vec![0_u8; 100_000])));
        Ok(())
    };
    assert_eq!(run(LONG, 0, in_turn), Ok(()));
}

/// A loader that follows any path.
fn resolve_all(folder: &Path, uri: &str) -> Vec<u8> {
    std::fs::read(folder.join(uri)).unwrap()
}

#[test]
fn a_read_outside_the_folder_is_caught() {
    let temporary = temporary();
    let place = &temporary.place;
    let whole = seeds::picture(ImageFormat::Png, [1, 2, 3]);
    for (buffer, picture) in [("../outside/tri.bin", None), ("tri.bin", Some("../outside/image.png"))] {
        place.write("tri.bin", &seeds::buffer(1.0));
        let buffer = resolve_all(&place.inside, buffer);
        let picture = picture.map_or_else(|| whole.clone(), |uri| resolve_all(&place.inside, uri));
        place.write_scene(&seeds::scene_json(buffer.len()), &buffer, &picture);
        let scene = load_scene(&place.inside.join("scene.gltf")).unwrap();
        assert!(check_scene(&scene).unwrap_err().contains("from outside"));
    }
}

#[test]
fn poor_errors_are_caught() {
    let path = Path::new("/folder/scene.gltf");
    check_error("/folder/scene.gltf: mesh 0: it has no POSITION", path).unwrap();
    for poor in
        ["no file", "/folder/scene.gltf: \u{1b}[31m", &format!("/folder/scene.gltf: {}", "x".repeat(9999))]
    {
        assert!(check_error(poor, path).is_err(), "{poor:.50}");
    }
}
