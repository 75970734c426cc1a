//! From the exact figures, how long a frame may take: an estimate, as nobody has measured it.

use crate::traffic::Bytes;
use quell::layout::{LEVEL_STRIDES, TILE};

pub const RULES: &str = "\
AN ESTIMATE, NOT A MEASUREMENT. Milliseconds of each kernel: the longer of compulsory traffic over bandwidth (`memory`) and \
`cycles` on RDNA 2 over arithmetic throughput (`compute`); a frame is their sum, kernels do not overlap. Assumed: 80 % of \
peak bandwidth and perfect caches, though a last-level cache that holds what the next kernel reads would save traffic, and \
taps that miss would add to it; 50 % of peak FP32, at which 64 invocations take the same lanes and cycles on another \
architecture; one model for 117 pixels, as measured on the demo's scenes; 5 microseconds for each dispatch to drain and the next \
to start (`dispatches`). `cycles` guesses the rounds of loops: kernels that sum over 64 pixels or 25 tiles take longer.";

const BANDWIDTH_SHARE: f64 = 0.8;
const COMPUTE_SHARE: f64 = 0.5;
/// Of which one gets a model of its own.
const PIXELS_A_MODEL: f64 = 117.0;
const DISPATCH_MS: f64 = 0.005;
/// Lanes of the SIMD that `cycles` are of.
const SIMD_LANES: f64 = 32.0;

pub struct Gpu {
    pub name: &'static str,
    pub gigabytes_a_second: f64,
    /// At boost clock; a fused multiply-add is two.
    pub teraflops: f64,
    pub source: &'static str,
}

pub const GPUS: [Gpu; 2] = [
    Gpu {
        name: "RX 6900 XT",
        gigabytes_a_second: 512.0,
        teraflops: 23.04,
        source: "AMD's product page: 256 bit GDDR6 at 16 Gbit/s; 80 compute units of 64 lanes at 2.25 GHz boost",
    },
    Gpu {
        name: "RTX 4080",
        gigabytes_a_second: 716.8,
        teraflops: 48.74,
        source: "NVIDIA's Ada whitepaper: 256 bit GDDR6X at 22.4 Gbit/s; 9728 lanes at 2.505 GHz boost",
    },
];

/// Milliseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Times {
    pub memory: f64,
    pub compute: f64,
    pub dispatches: f64,
}

impl Times {
    pub fn total(self) -> f64 {
        self.memory.max(self.compute) + self.dispatches
    }
}

/// `cycles` are of 64 invocations.
pub fn times(
    gpu: &Gpu,
    kernel: &str,
    invocations: u32,
    bytes: Bytes,
    cycles: f64,
    [w, h]: [u32; 2],
) -> Times {
    let pixels = f64::from(w) * f64::from(h);
    let tiles = pixels / f64::from(TILE * TILE);
    let levels = LEVEL_STRIDES.len() as f64;
    let (workgroups, dispatches) = match kernel {
        "clears" => (0.0, 1.0),
        "fit" => (pixels / PIXELS_A_MODEL, levels),
        "centres" => {
            let cells: f64 = LEVEL_STRIDES.map(|stride| tiles / f64::from(stride * stride)).iter().sum();
            (cells / f64::from(invocations), levels)
        }
        // A workgroup per tile.
        _ => (tiles, 1.0),
    };
    let waves = workgroups * f64::from(invocations) / 64.0;
    let lanes_a_second = gpu.teraflops / 2.0 * 1e12 * COMPUTE_SHARE;
    Times {
        memory: 1e3 * bytes.total(0) * pixels / (gpu.gigabytes_a_second * 1e9 * BANDWIDTH_SHARE),
        compute: 1e3 * waves * cycles * SIMD_LANES / lanes_a_second,
        dispatches: dispatches * DISPATCH_MS,
    }
}

#[test]
fn a_copy_takes_as_long_as_its_bytes_at_the_assumed_bandwidth() {
    let copy = Bytes { read: [4.0; 2], written: [4.0; 2] };
    let gpu = Gpu { name: "round", gigabytes_a_second: 100.0, teraflops: 1.0, source: "" };
    let found = times(&gpu, "copy", 64, copy, 100.0, [1000, 1000]);
    assert!((found.memory - 0.1).abs() < 1e-12, "{found:?}"); // 8 MB at 80 GB/s
    assert!((found.compute - 0.2).abs() < 1e-12, "{found:?}"); // 15625 tiles, 3200 lanes each, at 0.25e12
    assert_eq!(found.total(), 0.2 + DISPATCH_MS);
}
