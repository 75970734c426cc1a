//! From the exact figures, how long a frame may take: an estimate, as nobody has measured it.

use crate::traffic::Bytes;
use crate::work::Work;
use quell::layout::{LEVEL_STRIDES, TILE};

pub const RULES: &str = "\
AN ESTIMATE, NOT A MEASUREMENT. Milliseconds at 1920x1080: of compulsory traffic at 80 % of peak bandwidth (`memory`); of the \
driver's `cycles` on RDNA 2 (`by driver`), which guess how often loops run and branches are taken; of the work counted above \
(`by work`), where all branches are taken. A kernel takes the longer of `memory` and of one of the others, by which it has a \
least and a most, and 5 microseconds for each dispatch to drain and the next to start (`dispatches`); a frame is their sum, at \
both sizes. Assumed: half of peak FP32, which is one operation a lane and cycle; for 64 of these, 32 words of workgroup memory \
or of buffers, or 4 texels, as on RDNA 2 and in lack of better on others; one model for 190 pixels, as in frames of 640x360. Ignored: caches that hold what the next kernel reads, which would save traffic; taps that miss, which would add to it; \
latency that too few waves hide. Waves are of 64 lanes on AMD's, as its driver makes them, of 32 on NVIDIA's. `bound by` says which of these a kernel waits for.";

const BANDWIDTH_SHARE: f64 = 0.8;
const COMPUTE_SHARE: f64 = 0.5;
/// Operations that pass while a word of workgroup memory, a word of a buffer, a texel does.
const SHARED: f64 = 2.0;
const BUFFERS: f64 = 2.0;
const TEXELS: f64 = 16.0;
/// Of which one gets a model of its own.
const PIXELS_A_MODEL: f64 = 190.0;
const DISPATCH_MS: f64 = 0.005;
/// Lanes of the SIMD that `cycles` are of.
const SIMD_LANES: f64 = 32.0;

pub struct Gpu {
    pub name: &'static str,
    pub gigabytes_a_second: f64,
    /// At boost clock; a fused multiply-add is two.
    pub teraflops: f64,
    /// Lanes that wait for each other; those that a workgroup does not fill idle.
    pub wave: u32,
    pub source: &'static str,
}

pub const GPUS: [Gpu; 2] = [
    Gpu {
        name: "RX 6900 XT",
        gigabytes_a_second: 512.0,
        teraflops: 23.04,
        wave: 64,
        source: "AMD's product page: 256 bit GDDR6 at 16 Gbit/s; 80 compute units of 64 lanes at 2.25 GHz boost",
    },
    Gpu {
        name: "RTX 4080",
        gigabytes_a_second: 716.8,
        teraflops: 48.74,
        wave: 32,
        source: "NVIDIA's Ada whitepaper: 256 bit GDDR6X at 22.4 Gbit/s; 9728 lanes at 2.505 GHz boost",
    },
];

/// What a kernel is known to need.
#[derive(Debug, Clone, Copy, Default)]
pub struct Need {
    pub bytes: Bytes,
    pub work: Work,
    /// A SIMD's, for 64 invocations.
    pub cycles: f64,
    /// Of a workgroup.
    pub invocations: u32,
    /// That a workgroup of `innovation` stands for.
    pub tiles: f64,
}

/// Milliseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Times {
    pub memory: f64,
    pub by_driver: f64,
    pub by_work: f64,
    pub dispatches: f64,
}

impl Times {
    pub fn least(self) -> f64 {
        self.memory.max(self.by_driver.min(self.by_work)) + self.dispatches
    }

    /// What a kernel waits for, by both ways to tell its arithmetic, or by one.
    pub fn bound(self) -> &'static str {
        let [less, more] = [self.by_driver.min(self.by_work), self.by_driver.max(self.by_work)];
        match self {
            _ if self.dispatches >= self.memory.max(more) => "dispatches",
            _ if self.memory >= more => "memory",
            _ if self.memory <= less => "work",
            _ => "memory or work",
        }
    }

    pub fn most(self) -> f64 {
        self.memory.max(self.by_driver.max(self.by_work)) + self.dispatches
    }
}

pub fn times(gpu: &Gpu, kernel: &str, need: &Need, [width, height]: [u32; 2]) -> Times {
    let pixels = f64::from(width) * f64::from(height);
    let tiles = pixels / f64::from(TILE * TILE);
    let levels = LEVEL_STRIDES.len() as f64;
    let (workgroups, dispatches) = match kernel {
        "clears" => (0.0, 1.0),
        "fit" => (pixels / PIXELS_A_MODEL, levels),
        "centres" => {
            let cells: f64 = LEVEL_STRIDES.map(|stride| tiles / f64::from(stride * stride)).iter().sum();
            (cells / f64::from(need.invocations), levels)
        }
        "innovation" => (tiles / need.tiles, 1.0),
        // An invocation per pixel.
        _ => (pixels / f64::from(need.invocations), 1.0),
    };
    let invocations = workgroups * f64::from(need.invocations.next_multiple_of(gpu.wave));
    let operations_a_second = gpu.teraflops * 1e12 * COMPUTE_SHARE;
    let Work { operations, shared, buffers, texels, .. } = need.work;
    let operations =
        operations as f64 + SHARED * shared as f64 + BUFFERS * buffers as f64 + TEXELS * texels as f64;
    Times {
        memory: 1e3 * need.bytes.total(0) * pixels / (gpu.gigabytes_a_second * 1e9 * BANDWIDTH_SHARE),
        by_driver: 1e3 * invocations / 64.0 * need.cycles * SIMD_LANES / operations_a_second,
        by_work: 1e3 * invocations * operations / operations_a_second,
        dispatches: dispatches * DISPATCH_MS,
    }
}

#[test]
fn a_copy_takes_as_long_as_its_bytes_at_the_assumed_bandwidth() {
    let gpu = Gpu { name: "round", gigabytes_a_second: 100.0, teraflops: 1.0, wave: 64, source: "" };
    let need = Need {
        bytes: Bytes { read: [4.0; 2], written: [4.0; 2] },
        work: Work { operations: 10, shared: 1, buffers: 1, texels: 1, barriers: 3 },
        cycles: 100.0,
        invocations: 64,
        tiles: 1.0,
    };
    let found = times(&gpu, "copy", &need, [1000, 1000]);
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert!(near(found.memory, 0.1), "{found:?}"); // 8 MB at 80 GB/s
    assert!(near(found.by_driver, 0.1), "{found:?}"); // 15625 waves of 3200 lanes, at 0.5e12
    assert!(near(found.by_work, 0.06), "{found:?}"); // 1e6 invocations of 30, at 0.5e12
    assert_eq!(found.bound(), "memory");
    assert_eq!(Times { by_driver: 0.05, by_work: 0.2, ..found }.bound(), "memory or work");
    assert_eq!(Times { memory: 0.01, ..found }.bound(), "work");
    assert!(near(found.least(), 0.1 + DISPATCH_MS) && near(found.most(), 0.1 + DISPATCH_MS));
}
