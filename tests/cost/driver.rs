//! What a real driver's compiler makes of every kernel, for two architectures.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, Stdio};

pub const RULES: &str = "\
What RADV, Mesa's driver for AMD GPUs, compiles the kernels to, from the SPIR-V that wgpu makes of them, checks of bounds \
and loops included. `occupancy` is how many waves a SIMD holds at once, in waves of 32, of at most 32. `cycles` is its compiler's own estimate of how long a SIMD is busy with 64 invocations, latency and \
occupancy included; how often loops run and branches are taken it guesses, and its guess is not the shader's. Spills fail the test wherever it runs; the \
other figures are compared where Mesa's version is the same.";

/// What `RADV_FORCE_FAMILY` calls the architectures, and a GPU of each.
pub const FAMILIES: [(&str, &str); 2] =
    [("navi21", "RDNA 2, as in RX 6900 XT"), ("gfx1100", "RDNA 3, as in RX 7900 XTX")];

pub const CYCLES: &str = "Inverse Throughput";

/// Column of the table and statistic of the driver.
pub const COLUMNS: [(&str, &str); 11] = [
    ("wave size", "Wave size"),
    ("VGPRs", "VGPRs"),
    ("SGPRs", "SGPRs"),
    ("spilled VGPRs", "Spilled VGPRs"),
    ("spilled SGPRs", "Spilled SGPRs"),
    ("scratch bytes", "Scratch size"),
    ("LDS bytes", "LDS size"),
    ("occupancy", "Subgroups per SIMD"),
    ("instructions", "Instructions"),
    ("code bytes", "Code size"),
    ("cycles", CYCLES),
];

/// Of one architecture.
pub struct Compiled {
    /// Such as `Mesa 22.3.6`.
    pub driver: String,
    /// By kernel and statistic.
    pub statistics: BTreeMap<(String, String), u64>,
}

/// Set for the child process: where to write its report.
const REPORT: &str = "QUELL_COST_REPORT";

/// Whether the driver has to be there.
pub fn expected() -> bool {
    cfg!(all(target_os = "linux", target_arch = "x86_64"))
}

/// By architecture, in the order of [`FAMILIES`].
///
/// # Panics
/// Where RADV is missing or fails: a table without it would pass unseen.
pub fn compile() -> [Compiled; 2] {
    let icd = manifest().expect(
        "RADV is missing, Mesa's Vulkan driver for AMD GPUs (no GPU is needed): apt-get install mesa-vulkan-drivers",
    );
    let children = FAMILIES.map(|(family, _)| {
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("cost-{family}.tsv"));
        let _ = std::fs::remove_file(&path);
        let child = Command::new(std::env::current_exe().unwrap())
            .args(["--ignored", "--exact", "driver::child", "--nocapture"])
            .env("RADV_FORCE_FAMILY", family)
            .env("VK_ICD_FILENAMES", &icd)
            .env("VK_DRIVER_FILES", &icd)
            // A cached pipeline has no statistics.
            .env("MESA_SHADER_CACHE_DISABLE", "true")
            .env(REPORT, &path)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        (family, path, child)
    });
    children.map(|(family, path, child)| {
        let output = child.wait_with_output().unwrap();
        let report = std::fs::read_to_string(path).unwrap_or_else(|_| {
            let said = [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned());
            panic!("RADV did not compile the kernels for {family}:\n{}", said.join("\n"))
        });
        parse(&report)
    })
}

fn parse(report: &str) -> Compiled {
    let mut compiled = Compiled { driver: String::new(), statistics: BTreeMap::new() };
    for line in report.lines() {
        match *line.split('\t').collect::<Vec<_>>().as_slice() {
            ["driver", driver] => compiled.driver = driver.to_owned(),
            [kernel, statistic, value] => {
                let value = value.parse().expect("the child writes numbers");
                compiled.statistics.insert((kernel.to_owned(), statistic.to_owned()), value);
            }
            _ => panic!("not a line of the child's report: {line}"),
        }
    }
    compiled
}

/// The driver's manifest for the Vulkan loader.
fn manifest() -> Option<PathBuf> {
    let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"];
    let files = folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten();
    files.flatten().map(|file| file.path()).find(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("radeon_icd") && !name.contains("i686")
    })
}

/// What [`compile`] starts this binary again for.
#[test]
#[ignore = "runs in a child process with the driver's environment"]
fn child() {
    let Ok(path) = std::env::var(REPORT) else { return };
    #[cfg(all(target_os = "linux", target_arch = "x86_64"))]
    std::fs::write(path, crate::radv::report().unwrap()).unwrap();
    #[cfg(not(all(target_os = "linux", target_arch = "x86_64")))]
    panic!("{path}: RADV is asked on Linux on x86_64 only");
}
