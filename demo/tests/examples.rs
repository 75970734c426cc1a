//! The examples as a reader runs them: what they print, the pictures that they write, and how they fail.

mod render_graph;

use image::RgbaImage;
use std::path::Path;
use std::process::{Command, Output};

/// Runs an example in a small size. Cargo builds them for `cargo test`; for a single test target it does not.
fn example(name: &str, out: &Path, arguments: &[&str]) -> Output {
    let binary = Path::new(env!("CARGO_BIN_EXE_quell-demo"));
    let path = binary.with_file_name("examples").join(name).with_extension(std::env::consts::EXE_EXTENSION);
    let mut command = Command::new(&path);
    command.args(["--frames", "8", "--out", out.to_str().unwrap()]).args(arguments);
    // The examples choose adapters by wgpu's own variable.
    if let Ok(adapter) = std::env::var("QUELL_ADAPTER") {
        command.env("WGPU_ADAPTER_NAME", adapter);
    }
    let hint = "`cargo build -p quell-demo --examples` builds it";
    command.output().unwrap_or_else(|error| panic!("{}: {error}; {hint}", path.display()))
}

fn assert_succeeds(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn assert_fails(output: &Output, code: i32, part: &str) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(message.contains(part) && !message.contains("panicked"), "`{part}` is not in: {message}");
}

/// The number of decibels on the line that begins so.
fn decibels(printed: &str, line: &str) -> f64 {
    let number = printed.lines().find_map(|l| l.strip_prefix(line)?.strip_prefix(": ")?.strip_suffix(" dB"));
    number.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("no `{line}` in: {printed}"))
}

fn picture(folder: &Path, name: &str, size: (u32, u32)) -> RgbaImage {
    let picture = image::open(folder.join(name).with_extension("png")).unwrap().to_rgba8();
    assert_eq!(picture.dimensions(), size, "{name}");
    let first = *picture.get_pixel(0, 0);
    assert!(picture.pixels().any(|pixel| *pixel != first), "{name} is one colour");
    picture
}

/// Written anew, so that what an example prints is what its pictures show.
fn psnr_db(picture: &RgbaImage, reference: &RgbaImage) -> f64 {
    let channels = |image: &RgbaImage| -> Vec<f64> {
        image.pixels().flat_map(|pixel| [0, 1, 2].map(|c| f64::from(pixel.0[c]) / 255.0)).collect()
    };
    let (a, b) = (channels(picture), channels(reference));
    let mean = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64;
    -10.0 * mean.log10()
}

/// That denoised pictures are better than noisy ones by so much, and that the example says so.
fn assert_denoised(folder: &Path, printed: &str, size: (u32, u32), gain_db: f64) {
    let reference = picture(folder, "reference", size);
    let [noisy, denoised] = ["noisy", "denoised"].map(|name| {
        let measured = psnr_db(&picture(folder, name, size), &reference);
        let said = decibels(printed, name);
        assert!((measured - said).abs() < 0.01, "{name}: {measured} dB, but it says {said}");
        measured
    });
    assert!(denoised > noisy + gain_db, "{noisy} dB noisy, {denoised} dB denoised");
}

#[test]
fn integrate_denoises() {
    let folder = tempfile::tempdir().unwrap();
    let printed = assert_succeeds(&example("integrate", folder.path(), &["--size", "96x64"]));
    assert_denoised(folder.path(), &printed, (96, 64), 10.0);
}

#[test]
fn integrate_is_short() {
    assert!(include_str!("../examples/integrate.rs").lines().count() < 300);
}

#[test]
fn wrong_arguments_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let [out, file] = ["out", "file"].map(|name| folder.path().join(name));
    std::fs::write(&file, "").unwrap();
    for name in ["integrate", "reverse_z", "render_graph"] {
        assert_fails(&example(name, &out, &["--size", "96"]), 1, "640x360");
        assert_fails(&example(name, &out, &["--size", "96xx"]), 2, "--size");
        assert_fails(&example(name, &out, &["--size", "0x64"]), 1, "pixel");
        assert_fails(&example(name, &file, &["--size", "96x64"]), 1, "cannot create");
    }
}

#[test]
fn an_engine_with_other_conventions_gets_the_same_image() {
    let folder = tempfile::tempdir().unwrap();
    let size = ["--size", "96x64"];
    let printed = assert_succeeds(&example("reverse_z", folder.path(), &size));
    let alike = decibels(&printed, "this engine's, against quell's own conventions");
    assert!(alike > 68.0, "{printed}");
    let own = picture(folder.path(), "own_conventions", (96, 64));
    let [noisy, denoised] =
        ["noisy", "denoised"].map(|name| psnr_db(&picture(folder.path(), name, (96, 64)), &own));
    assert!((denoised - alike).abs() < 0.01, "{denoised} dB, but it says {alike}");
    // Not merely two pictures that are alike because nothing was denoised.
    assert!(noisy < 35.0, "{noisy} dB");

    let mistaken = |mistake| example("reverse_z", folder.path(), &[size[0], size[1], "--mistake", mistake]);
    for mistake in ["motion-unit", "motion-direction", "motion-jitter", "normal-space"] {
        assert_fails(&mistaken(mistake), 1, "a convention is told wrong");
    }
    assert_fails(&mistaken("depth"), 1, "Depth32Float");
    assert_fails(&mistaken("depth"), 1, "another `Conventions::depth`");
    assert_fails(&mistaken("normal-encoding"), 1, "another `Conventions::normal_encoding`");
}

#[test]
fn the_render_graph_denoises_two_views_and_recycles() {
    let folder = tempfile::tempdir().unwrap();
    let printed = assert_succeeds(&example("render_graph", folder.path(), &["--size", "192x64"]));
    assert_denoised(folder.path(), &printed, (192, 64), 8.0);
    let parts = [
        "frame 0: gbuffer > trace > denoise > glow > tonemap > present; culled: []",
        // Nine textures a view: one is another's, and the second view has those of the first.
        "frame 0: 8 textures created, 10 recycled, 0 dropped, 8 held",
        "frame 4: the window is resized to 192x64",
        "frame 5: 0 textures created, 18 recycled, 8 dropped, 8 held",
        "frame 7: gbuffer > trace > glow > tonemap > present; culled: [\"denoise\"]",
    ];
    for part in parts {
        assert!(printed.contains(part), "`{part}` is not in: {printed}");
    }
    for pass in quell::PASSES {
        assert!(printed.contains(&format!("\n  {pass}: ")), "`{pass}` is not timed: {printed}");
    }
}
