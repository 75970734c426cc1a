//! The same walks on two drivers that have nothing in common: Mesa's lavapipe, and SwiftShader, which Chromium carries. Each
//! renders in a process of its own, which sees no other driver.

use crate::walks::{self, Frame, Walk};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;

/// Where the child writes its frames.
const REPORT: &str = "QUELL_PORTABILITY_REPORT";
/// Overrides where SwiftShader's manifest is looked for.
const SWIFTSHADER: &str = "QUELL_SWIFTSHADER_ICD";

/// What adapters of the two drivers have in their names.
const DRIVERS: [&str; 2] = ["llvmpipe", "SwiftShader"];

/// Frames of all walks, one walk after the other, by driver.
fn rendered() -> &'static [Vec<Vec<Frame>>; 2] {
    static RENDERED: OnceLock<[Vec<Vec<Frame>>; 2]> = OnceLock::new();
    RENDERED.get_or_init(|| {
        let children = [spawn(DRIVERS[0], &lavapipe()), spawn(DRIVERS[1], &swiftshader())];
        children.map(|(name, path, child)| {
            let output = child.wait_with_output().unwrap();
            let said = [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned());
            let report = std::fs::read(path).unwrap_or_else(|_| panic!("{name} failed:\n{}", said.join("\n")));
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
    let adapter = crate::gpu::gpu().device.adapter_info().name;
    let frames = Walk::ALL.into_iter().flat_map(walks::render).collect::<Vec<_>>();
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

#[test]
fn two_drivers_agree() {
    let [ours, theirs] = rendered();
    for (i, walk) in Walk::ALL.into_iter().enumerate() {
        for (j, (a, b)) in ours[i].iter().zip(&theirs[i]).enumerate() {
            let d = walks::difference(a, b);
            println!("{walk:?} {j:2} {d:?}");
        }
    }
}
