//! What the packed images keep of what is put into them, on the GPU: precision, ends of ranges, and rounding that does not
//! drift.

use super::packed::{
    DEVIATION_STEPS, NO_SAMPLE, Noise, Prediction, RELATIVE_NOISE_STEPS, deviation_unit, signal_step,
    unpack_signal,
};
use super::run;
use super::surface::{Surface, pack, unpack};
use crate::gpu::{download_buffer, download_words, gpu, upload_buffer, upload_words};
use bytemuck::Zeroable;
use glam::DVec3;
use quell::gpu::{FrameUniforms, Kernel, KernelDescriptor, Kind};
use rand::{Rng, SeedableRng, rngs::StdRng};

/// Numbers that a case is given and leaves behind; it also leaves two words.
const NUMBERS: usize = 8;

const PROBE: &str = "
//!include frame numbers noise surface signal features models
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> given: array<f32>;
@group(0) @binding(2) var<storage, read_write> words: array<u32>;
@group(0) @binding(3) var<storage, read_write> found: array<f32>;
@group(0) @binding(4) var sample_count: texture_2d<u32>;
const OWN_FEATURES = MODEL_OWN_FEATURES;

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = 8u * id.x;
    if at >= arrayLength(&given) {
        return;
    }
    let g = array(given[at], given[at + 1], given[at + 2], given[at + 3], given[at + 4], given[at + 5], given[at + 6]);
    let pixel = vec2(id.x % 64u, id.x / 64u);
    var w = vec2(0u);
    var f: array<f32, 8>;
    CASE
    words[2u * id.x] = w.x;
    words[2u * id.x + 1u] = w.y;
    for (var i = 0u; i < 8u; i++) {
        found[at + i] = f[i];
    }
}
";

/// Runs a few lines of WGSL on each of the cases.
fn probe(case: &str, given: &[[f32; NUMBERS]]) -> Vec<([u32; 2], [f64; NUMBERS])> {
    let descriptor: &'static KernelDescriptor = Box::leak(Box::new(KernelDescriptor {
        name: "probe",
        source: PROBE.replace("CASE", case).leak(),
        bindings: &[
            ("frame", Kind::Frame),
            ("given", Kind::Buffer),
            ("words", Kind::BufferMut),
            ("found", Kind::BufferMut),
        ],
        workgroup: [64, 1],
        covers: [64, 1],
    }));
    let kernel = Kernel::new(&gpu().device, descriptor);
    let input = upload_buffer(given.as_flattened());
    let words = upload_words(&vec![0; 2 * given.len()]);
    let found = upload_buffer(&vec![f32::NAN; NUMBERS * given.len()]);
    run(&FrameUniforms::zeroed(), |recorder| {
        let resources = [&input, &words, &found].map(|buffer| buffer.as_entire_binding());
        kernel.record(recorder, &resources, [given.len() as u32, 1]);
    });
    let found = download_buffer(&found);
    let words = download_words(&words);
    let wide = |f: &[f32]| std::array::from_fn(|i| f[i].into());
    words.chunks(2).zip(found.chunks(NUMBERS)).map(|(w, f)| ([w[0], w[1]], wide(f))).collect()
}

fn case(numbers: &[f64]) -> [f32; NUMBERS] {
    std::array::from_fn(|i| *numbers.get(i).unwrap_or(&0.0) as f32)
}

const SURFACE: &str = "
    w = pack_surface(Surface(vec3(g[0], g[1], g[2]), g[3], g[4], g[5], u32(g[6])));
    let s = unpack_surface(w);
    f = array(s.normal.x, s.normal.y, s.normal.z, s.depth, s.cue, s.roughness, f32(s.id), 0.0);";

#[test]
fn surfaces_keep_what_their_bits_allow() {
    let mut random = StdRng::seed_from_u64(71);
    let axis = |i: usize| [-1.0, 0.0, 1.0][i % 3];
    let surfaces: Vec<Surface> = (0..4096)
        .map(|i| {
            // All corners and edges of the octahedron, then any direction.
            let corner = DVec3::new(axis(i), axis(i / 3), axis(i / 9));
            let any = DVec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
            Surface {
                normal: if i < 27 { corner } else { any }.try_normalize().unwrap_or(DVec3::Z),
                depth: random.random_range(-19.0..19.0_f64).exp2().powi(i as i32 % 3 + 1),
                cue: random.random_range(0.1..=1.0),
                roughness: random.random_range(0.0..=1.0),
                id: random.random_range(0..1024),
            }
        })
        .collect();
    let given = surfaces.iter().map(|s| {
        let [x, y, z] = s.normal.to_array();
        case(&[x, y, z, s.depth, s.cue, s.roughness, s.id.into()])
    });
    let mut unequal = 0;
    for ((words, found), s) in probe(SURFACE, &given.collect::<Vec<_>>()).into_iter().zip(&surfaces) {
        unequal += usize::from(words != pack(s));
        // The GPU reads its words as the twin does.
        let twin = unpack(words);
        let normal = DVec3::new(found[0], found[1], found[2]);
        assert!((normal - twin.normal).length() < 1e-6, "{normal} {s:?}");
        let read = [twin.depth, twin.cue, twin.roughness, f64::from(twin.id)];
        assert!(found[3..7].iter().zip(read).all(|(f, t)| (f - t).abs() <= 1e-6 * t), "{found:?} {twin:?}");
        // Half a step of 1/1023 in each axis of the octahedron's square, stretched by up to 3.
        assert!(normal.angle_between(s.normal) < 0.5 * 2.0_f64.sqrt() / 1023.0 * 3.0, "{normal} {s:?}");
        assert!((found[3] / s.depth - 1.0).abs() < 1.001 / 16384.0, "{found:?} {s:?}");
        assert!((found[4].sqrt() - s.cue.sqrt()).abs() < 0.501 / 127.0);
        assert!((found[5] - s.roughness).abs() < 0.501 / 31.0);
        assert_eq!(found[6], f64::from(s.id));
    }
    assert!(unequal < 20, "{unequal} are rounded otherwise than by the twin");
}

#[test]
fn surfaces_at_the_ends_of_their_ranges() {
    let depths = [0.0, 1e-30, 2.0_f64.powi(-63), 1e12, 1e30];
    let given: Vec<_> =
        depths.iter().map(|&depth| case(&[0.0, 0.0, -1.0, depth, 5.0, 1.0, 1023.0])).collect();
    let found: Vec<_> = probe(SURFACE, &given).into_iter().map(|(_, found)| found).collect();
    for f in &found {
        assert_eq!(f[..3], [0.0, 0.0, -1.0]);
        assert_eq!(f[4..7], [1.0, 1.0, 1023.0]); // beyond 1 nothing is nearer
    }
    // A miss stays one, and nothing else becomes one.
    assert_eq!(found[0][3], 0.0);
    assert!(found[1][3] > 0.0 && found[1][3] < 1e-19, "{:?}", found[1]);
    assert_eq!(found[2][3], depths[2]);
    assert!((found[3][3] / 1e12 - 1.0).abs() < 1.0 / 16384.0);
    assert!(found[4][3] > 1e19 && found[4][3] < 1e20, "{:?}", found[4]);
    let black = &probe(SURFACE, &[case(&[0.0, 0.0, 1.0, 1.0])])[0].1;
    assert_eq!(black[4..7], [0.0; 3]);
}

const SIGNAL: &str = "
    w.x = pack_signal(vec3(g[0], g[1], g[2]), pixel, 5u);
    let s = unpack_signal(w.x);
    f = array(s.x, s.y, s.z, 0.0, 0.0, 0.0, 0.0, 0.0);";

/// Copies of a case, whose number is enough for a mean to a few hundredths of a step.
const COPIES: usize = 4096;
/// Four standard errors of the mean of as many values that are rounded at random, in steps.
const UNBIASED: f64 = 4.0 * 0.5 / 64.0;

#[test]
fn samples_are_kept_to_a_step_and_right_in_the_mean() {
    let mut random = StdRng::seed_from_u64(72);
    let mut colours: Vec<[f64; 3]> = (0..40)
        .map(|_| {
            let level = random.random_range(-20.0..15.0_f64).exp2();
            std::array::from_fn(|_| level * random.random_range(0.0..1.0))
        })
        .collect();
    // Just below a power of two, where the mantissa has no place to be rounded up to; and very small ones.
    colours.extend([[1.9985, 1.0, 0.001], [255.9, 0.0, 255.6], [0.124_99, 0.1, 0.0], [3e-5, 1e-6, 3e-8]]);
    for colour in colours.iter().map(|colour| colour.map(|c| f64::from(c as f32))) {
        let step = signal_step(colour);
        let mut sum = [0.0; 3];
        for ([word, _], found) in probe(SIGNAL, &vec![case(&colour); COPIES]) {
            assert_ne!(word, NO_SAMPLE);
            assert_eq!(unpack_signal(word), [found[0], found[1], found[2]]);
            for c in 0..3 {
                assert!((found[c] - colour[c]).abs() < step, "{found:?} {colour:?}");
                sum[c] += found[c];
            }
        }
        for c in 0..3 {
            let off = (sum[c] / COPIES as f64 - colour[c]) / step;
            assert!(off.abs() < UNBIASED, "{colour:?} is off by {off} steps in the mean");
        }
    }
}

/// Whatever a sample's colour, it is not taken for none; what is too bright is as bright as can be.
#[test]
fn samples_at_the_ends_of_their_range() {
    assert_eq!(unpack_signal(probe(SIGNAL, &[case(&[0.0; 3])])[0].0[0]), [0.0; 3]);
    for colour in [[65408.0; 3], [65504.0; 3], [1e30; 3], [f64::INFINITY; 3], [1e9, 0.0, 65408.0]] {
        for ([word, _], found) in probe(SIGNAL, &vec![case(&colour); COPIES]) {
            assert_ne!(word, NO_SAMPLE);
            // The word of no sample is that of the brightest white, which one channel evades by one step of 128.
            let dimmest = colour.map(|c: f64| c.min(65408.0 - 128.0));
            assert!((0..3).all(|c| found[c] >= dimmest[c] && found[c] <= 65408.0), "{found:?}");
        }
    }
}

const NOISE: &str = "
    w.x = pack_noise(Noise(g[0], vec3(g[1], g[2], g[3])), g[4], pixel, 5u);
    let n = unpack_noise(w.x, g[4]);
    f = array(n.variance, n.deviations.x, n.deviations.y, n.deviations.z, 0.0, 0.0, 0.0, 0.0);";

#[test]
fn noises_are_kept_to_a_step_and_right_in_the_mean() {
    let mut random = StdRng::seed_from_u64(73);
    for _ in 0..40 {
        let deviation = random.random_range(-20.0..12.0_f64).exp2();
        let count = random.random_range(0.0..10.0_f64).exp2();
        // Within the range, of which one step is left for rounding the unit up or down.
        let of_mean = deviation / count.sqrt();
        let deviations: [f64; 3] = std::array::from_fn(|_| random.random_range(-3.9..3.9) * of_mean);
        let given = case(&[deviation * deviation, deviations[0], deviations[1], deviations[2], count]);
        let mut sum = [0.0; 4];
        for ([word, _], found) in probe(NOISE, &vec![given; COPIES]) {
            let twin = Noise::unpack(word, given[4].into());
            // exp2 of the GPU is good to 1e-5 at 24 octaves.
            assert!((found[0] / twin.variance - 1.0).abs() < 1e-4, "{found:?} {twin:?}");
            let octaves = 0.5 * found[0].log2() - deviation.log2();
            assert!(octaves.abs() * DEVIATION_STEPS < 1.01, "{found:?} {deviation}");
            sum[0] += octaves * DEVIATION_STEPS;
            let unit = deviation_unit(found[0].sqrt(), count);
            for k in 0..3 {
                assert!((found[1 + k] - twin.deviations[k]).abs() <= 1e-4 * of_mean);
                let off = (found[1 + k] - deviations[k]) / unit;
                assert!(off.abs() < 1.01, "{found:?} {deviations:?}");
                sum[1 + k] += off;
            }
        }
        let drift = sum.map(|sum| sum / COPIES as f64);
        assert!(drift.iter().all(|drift| drift.abs() < UNBIASED), "{deviation} {deviations:?}: {drift:?}");
    }
}

#[test]
fn noises_at_the_ends_of_their_ranges() {
    let all = |numbers: &[f64]| probe(NOISE, &vec![case(numbers); 256]).into_iter().map(|(_, found)| found);
    // Without samples, or without any noise, there are no deviations.
    assert!(all(&[0.0, 1.0, -1.0, 0.5, 4.0]).all(|found| found == [0.0; 8]));
    assert!(all(&[1e-20, 1.0, -1.0, 0.5, 4.0]).all(|found| found == [0.0; 8]));
    assert!(all(&[1.0, 1.0, -1.0, 0.5, 0.0]).all(|found| found[1..4] == [0.0; 3]));
    // A firefly's deviation is kept beside a variance that does not know of it: the variance becomes what has such a range.
    for found in all(&[1.0, 20.0, -20.0, 0.5, 4.0]) {
        assert!((found[0].sqrt() / 10.0).log2().abs() * DEVIATION_STEPS < 1.01, "{found:?}");
        let off = [found[1] - 20.0, found[2] + 20.0, found[3] - 0.5];
        let unit = deviation_unit(found[0].sqrt(), 4.0);
        assert!(off.iter().all(|off| off.abs() < 1.01 * unit), "{found:?}");
    }
    // What is beyond that lies at the end of the widest, 4096 times the variance.
    assert!(
        all(&[1.0, 1e9, 0.0, 0.0, 4.0])
            .all(|found| (found[0].sqrt() / 64.0).log2().abs() * DEVIATION_STEPS < 1.01)
    );
    for found in all(&[1.0, 1e9, -1e9, 0.0, 4.0]) {
        let most = 4.0 * found[0].sqrt() / 2.0;
        assert!((found[1] / most - 1.0).abs() < 1e-4 && (found[2] / most + 1.0).abs() < 1e-4, "{found:?}");
    }
    for found in all(&[1e30, 0.0, 0.0, 0.0, 1.0]) {
        assert!((found[0].sqrt() / 65536.0 - 1.0).abs() < 1e-4, "{found:?}");
    }
}

const PREDICTION: &str = "
    w = pack_prediction(Prediction(vec3(g[0], g[1], g[2]), g[3], g[4]));
    let p = unpack_prediction(w);
    f = array(p.signal.x, p.signal.y, p.signal.z, p.noise_gain, p.relative_noise, f32(is_known(p)), 0.0, 0.0);";

#[test]
fn predictions_keep_what_their_bits_allow() {
    let mut random = StdRng::seed_from_u64(74);
    let predictions: Vec<Prediction> = (0..4096)
        .map(|i| Prediction {
            signal: std::array::from_fn(|_| random.random_range(-10.0..15.9_f64).exp2()),
            noise_gain: [0.0, 1.0, random.random_range(0.0..1.0)][i % 3],
            relative_noise: random.random_range(-15.0..9.96_f64).exp2(),
        })
        .collect();
    let given = predictions
        .iter()
        .map(|p| case(&[p.signal[0], p.signal[1], p.signal[2], p.noise_gain, p.relative_noise]));
    for ((words, found), p) in probe(PREDICTION, &given.collect::<Vec<_>>()).into_iter().zip(&predictions) {
        let twin = Prediction::unpack(words);
        assert_eq!([found[0], found[1], found[2]], twin.signal);
        assert!(
            (found[3] - twin.noise_gain).abs() < 1e-6 && (found[4] / twin.relative_noise - 1.0).abs() < 1e-4
        );
        // A half float may be rounded either way.
        assert!((0..3).all(|c| (found[c] / p.signal[c] - 1.0).abs() < 1.0 / 1024.0), "{found:?} {p:?}");
        let gain_off = (found[3] - p.noise_gain).abs();
        assert!(
            gain_off < 0.501 / 255.0 && (gain_off == 0.0 || p.noise_gain.fract() != 0.0),
            "{found:?} {p:?}"
        );
        let octaves = (found[4] / p.relative_noise).log2();
        assert!(octaves.abs() * RELATIVE_NOISE_STEPS < 0.51 && found[5] == 1.0, "{found:?} {p:?}");
    }
}

#[test]
fn predictions_at_the_ends_of_their_ranges() {
    let of = |numbers: &[f64]| probe(PREDICTION, &[case(numbers)])[0].1;
    assert_eq!(of(&[0.0, 0.0, 0.0, 0.0, -1.0])[..6], [0.0, 0.0, 0.0, 0.0, -1.0, 0.0], "no model");
    let brightest = of(&[65504.0, 65504.0, 65504.0, 1.0, 1e3]);
    assert_eq!(brightest[..4], [65504.0, 65504.0, 65504.0, 1.0]);
    // Half a step of a tenth of an octave.
    assert!((brightest[4] / 1e3).log2().abs() * RELATIVE_NOISE_STEPS < 0.51, "{brightest:?}");
    // No noise is the least there is, and known.
    assert_eq!(of(&[1.0, 1.0, 1.0, 0.5, 0.0])[4..6], [2.0_f64.powi(-15), 1.0]);
    assert!(of(&[1.0, 1.0, 1.0, 0.5, 1e9])[4] >= 2047.0);
}
