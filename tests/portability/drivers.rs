//! The same walks on two drivers that have nothing in common: Mesa's lavapipe, and SwiftShader, which Chromium carries. Each
//! renders in a process of its own, which sees no other driver.

use crate::walks::{self, Difference, Frame, Walk};
use quell::Pipelines;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, OnceLock};

/// Where the child writes its frames.
const REPORT: &str = "QUELL_PORTABILITY_REPORT";
/// Overrides where SwiftShader's manifest is looked for.
const SWIFTSHADER: &str = "QUELL_SWIFTSHADER_ICD";

/// What adapters of the two drivers have in their names.
const DRIVERS: [&str; 2] = ["llvmpipe", "SwiftShader"];

/// Least PSNR of a frame against the other driver's, in dB, and the largest difference of two values. What differs comes of
/// `exp2`, `log2`, `pow` and `atan2`, whose last bits WGSL leaves open; now and then they tip a choice. Stores to half floats
/// would come to 80 dB alone, because drivers round them as they like, but `compose` rounds before.
const LEAST_PSNR: f64 = 90.0;
const LARGEST: f32 = 1.0 / 256.0;
/// How many pixels may be given another number of samples next: where the number before it is rounded was just at the border.
const MOST_SAMPLE_COUNTS: f64 = 0.005;

/// Why two frames do not agree; none where they do.
fn disagreement(a: &Frame, b: &Frame) -> Option<Difference> {
    let found = walks::difference(a, b);
    let agrees =
        found.psnr >= LEAST_PSNR && found.largest <= LARGEST && found.sample_counts <= MOST_SAMPLE_COUNTS;
    (!agrees).then_some(found)
}

#[test]
fn two_drivers_agree() {
    let [ours, theirs] = rendered();
    let mut disagreements = String::new();
    for (i, walk) in Walk::COMPARED.into_iter().enumerate() {
        for (frame, (a, b)) in ours[i].iter().zip(&theirs[i]).enumerate() {
            if let Some(found) = disagreement(a, b) {
                disagreements += &format!("  {walk:?}, frame {frame}: {found:?}\n");
            }
        }
        let found = || ours[i].iter().zip(&theirs[i]).map(|(a, b)| walks::difference(a, b));
        let least = found().map(|found| found.psnr).fold(f64::INFINITY, f64::min);
        let largest = found().map(|found| found.largest).fold(0.0, f32::max);
        println!("{walk:?}: at least {least:.1} dB, at most {largest:.6} apart");
    }
    assert!(disagreements.is_empty(), "{} and {} differ:\n{disagreements}", DRIVERS[0], DRIVERS[1]);
}

#[test]
fn other_noise_another_setting_and_a_wrong_tile_are_told_apart() {
    let [ours, _] = rendered();
    let of = |walk| &ours[Walk::ALL.iter().position(|&other| other == walk).unwrap()];
    let (right, noise, setting) = (of(Walk::Combined), of(Walk::OtherNoise), of(Walk::OtherSetting));
    assert!(right.iter().zip(noise).all(|(a, b)| disagreement(a, b).is_some()));
    let last = right.len() - 1;
    assert!(disagreement(&right[last], &setting[last]).is_some());
    let mut wrong = right[last].clone();
    for (i, pixel) in wrong.output.iter_mut().enumerate() {
        if (i as u32 % walks::SIZE[0]) < 8 && (i as u32 / walks::SIZE[0]) >= walks::SIZE[1] - 8 {
            *pixel = pixel.map(|value| value * 1.05);
        }
    }
    assert!(disagreement(&right[last], &wrong).is_some());
    assert!(disagreement(&right[last], &right[last]).is_none());
}

/// Frames of walks, by driver and walk: the first driver's of all, the second's of those that are compared.
fn rendered() -> &'static [Vec<Vec<Frame>>; 2] {
    static RENDERED: OnceLock<[Vec<Vec<Frame>>; 2]> = OnceLock::new();
    RENDERED.get_or_init(|| {
        let children = [spawn(DRIVERS[0], &lavapipe()), spawn(DRIVERS[1], &swiftshader())];
        children.map(|(name, path, child)| {
            let output = child.wait_with_output().unwrap();
            let said = [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned());
            let report =
                std::fs::read(path).unwrap_or_else(|_| panic!("{name} failed:\n{}", said.join("\n")));
            let end = report.iter().position(|&byte| byte == b'\n').unwrap();
            let adapter = String::from_utf8_lossy(&report[..end]);
            assert!(adapter.contains(name), "rendered on {adapter}, expected {name}");
            walks::unpack(&report[end + 1..])
        })
    })
}

fn spawn(name: &'static str, manifest: &Path) -> (&'static str, PathBuf, Child) {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("walks-{name}"));
    let _ = std::fs::remove_file(&path);
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--ignored", "--exact", "drivers::child", "--nocapture"])
        // The newer name wins in a Vulkan loader that knows both.
        .env("VK_DRIVER_FILES", manifest)
        .env("VK_ICD_FILENAMES", manifest)
        .env(REPORT, &path)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    (name, path, child)
}

/// What [`rendered`] starts this binary again for.
#[test]
#[ignore = "runs in a child process with the driver's environment"]
fn child() {
    let Ok(path) = std::env::var(REPORT) else { return };
    let device = &crate::gpu::gpu().device;
    let adapter = device.adapter_info().name;
    let walks = if adapter.contains(DRIVERS[0]) { Walk::ALL.to_vec() } else { Walk::COMPARED.to_vec() };
    let pipelines = Arc::new(Pipelines::new(device).unwrap());
    let frames: Vec<_> = walks.into_iter().flat_map(|walk| walks::render(walk, &pipelines)).collect();
    std::fs::write(path, [format!("{adapter}\n").as_bytes(), &walks::pack(&frames)].concat()).unwrap();
}

fn lavapipe() -> PathBuf {
    let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"];
    let files = folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten();
    let found = files.flatten().map(|file| file.path()).find(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("lvp_icd") && !name.contains("i686")
    });
    found.expect("lavapipe is missing, Mesa's Vulkan driver on the CPU: apt-get install mesa-vulkan-drivers")
}

fn swiftshader() -> PathBuf {
    let folders = [
        "/usr/lib/chromium",
        "/usr/lib64/chromium",
        "/usr/lib/chromium-browser",
        "/usr/lib64/chromium-browser",
        "/opt/google/chrome",
    ];
    let files = folders.iter().map(|folder| Path::new(folder).join("vk_swiftshader_icd.json"));
    let found = std::env::var_os(SWIFTSHADER).map(PathBuf::from).into_iter().chain(files);
    found.into_iter().find(|file| file.is_file()).unwrap_or_else(|| {
        panic!(
            "SwiftShader is missing, Chromium's Vulkan driver on the CPU: apt-get install chromium-common on Debian, or give its \
             vk_swiftshader_icd.json in {SWIFTSHADER}"
        )
    })
}
