//! The packed images in f64: what their words mean, and the words of what they hold.

use super::luminance;
use half::f16;
use rand::{Rng, rngs::StdRng};

/// What a word of the signal image says where a pixel has no sample.
pub const NO_SAMPLE: u32 = u32::MAX;

/// The hash that surface ids and dithering go through.
pub fn pcg(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

pub fn unpack_signal(word: u32) -> [f64; 3] {
    let scale = 2.0_f64.powi((word >> 27) as i32 - 24);
    [0, 9, 18].map(|shift| f64::from(word >> shift & 511) * scale)
}

/// What the mantissas of a colour count: the largest fits into 9 bits, also after it is rounded up.
pub fn signal_step(colour: [f64; 3]) -> f64 {
    let largest = colour.into_iter().fold(0.0, f64::max);
    (0..32).map(|exponent| 2.0_f64.powi(exponent - 24)).find(|step| largest <= 511.0 * step).unwrap()
}

/// Rounded to nearest.
pub fn pack_signal(colour: [f64; 3]) -> u32 {
    let step = signal_step(colour);
    let [r, g, b] = colour.map(|c| (c / step).round() as u32);
    r | g << 9 | b << 18 | ((step.log2() as i32 + 24) as u32) << 27
}

#[derive(Debug, Clone, Copy, Default)]
pub struct Noise {
    /// Of one sample's luminance.
    pub variance: f64,
    /// Of the temporal mean's luminance; each stands for it.
    pub deviations: [f64; 3],
}

/// Steps of the logarithm of a deviation of one sample, per octave.
pub const DEVIATION_STEPS: f64 = 2046.0 / 40.0;
/// The least that is told from none.
pub const LEAST_DEVIATION_OCTAVE: f64 = -24.0;

/// What a deviation's code of the mean of `count` samples counts.
pub fn deviation_unit(deviation: f64, count: f64) -> f64 {
    if count > 0.0 { 4.0 / 63.0 * deviation / count.sqrt() } else { 0.0 }
}

impl Noise {
    pub fn unpack(word: u32, count: f64) -> Self {
        let code = word >> 21;
        let octave = (f64::from(code) - 1.0) / DEVIATION_STEPS + LEAST_DEVIATION_OCTAVE;
        let deviation = if code == 0 { 0.0 } else { octave.exp2() };
        let unit = deviation_unit(deviation, count);
        let deviations = [0, 7, 14].map(|shift| (f64::from(word >> shift & 127) - 63.0) * unit);
        Self { variance: deviation * deviation, deviations }
    }

    /// As it is packed beside a mean of `count` samples: with a variance whose range the deviations do not leave, if that is at most
    /// 4096 times as large.
    pub fn widened(&self, count: f64) -> Self {
        let farthest = self.deviations.iter().fold(0.0, |most: f64, d| most.max(d.abs())) / 4.0;
        let variance = (count * farthest * farthest).clamp(self.variance, 4096.0 * self.variance);
        Self { variance, ..*self }
    }

    /// Variance of the temporal mean.
    pub fn found(&self) -> f64 {
        self.deviations.iter().map(|d| d * d).sum::<f64>() / 3.0
    }
}

/// Noises of any size, up to deviations of 1.4 of one sample, and none in places.
pub fn random_noise(random: &mut StdRng, pixels: usize) -> Vec<u32> {
    let most = (1.4_f64.log2() - LEAST_DEVIATION_OCTAVE) * DEVIATION_STEPS;
    let word = |random: &mut StdRng| {
        // Mostly of the size that samples have.
        let code = match random.random_range(0..20) {
            0 => 0,
            1 => random.random_range(1..most as u32),
            _ => most as u32 - random.random_range(0..150),
        };
        [0, 7, 14].into_iter().map(|shift| random.random_range(0..127_u32) << shift).sum::<u32>() | code << 21
    };
    (0..pixels).map(|_| word(random)).collect()
}

/// With a quarter of the deviations of the mean.
pub fn quieter(word: u32) -> u32 {
    let codes = [0, 7, 14].map(|shift| (((word >> shift & 127) + 3 * 63) / 4) << shift);
    codes.into_iter().sum::<u32>() | (word >> 21 << 21)
}

pub fn unpack_noises(words: &[u32], texels: &[[f64; 4]]) -> Vec<Noise> {
    words.iter().zip(texels).map(|(&word, texel)| Noise::unpack(word, texel[3])).collect()
}

/// How a noise image differs from what it should hold.
#[derive(Debug)]
pub struct NoiseDifference {
    /// Share of pixels that are off by more than the one step that random rounding may take.
    pub wrong: f64,
    /// Mean error of the deviation of one sample and of the mean's deviations, in steps: random rounding leaves none.
    pub drift: [f64; 2],
}

/// `texels` are those of the temporal mean beside the noise, as stored.
pub fn compare_noise(words: &[u32], texels: &[[f64; 4]], expected: &[Noise]) -> NoiseDifference {
    const ONE_STEP: f64 = 1.02; // and rounding of f32
    let (mut wrong, mut sums, mut counts) = (0, [0.0; 2], [0.0; 2]);
    for ((&word, texel), expected) in words.iter().zip(texels).zip(expected) {
        let found = Noise::unpack(word, texel[3]);
        let expected = expected.widened(texel[3]);
        let octave = expected.variance.sqrt().log2();
        let mut steps = vec![];
        if octave < LEAST_DEVIATION_OCTAVE {
            wrong += usize::from(found.variance > 0.0 || found.deviations != [0.0; 3]);
            continue;
        }
        steps.push((0, (found.variance.sqrt().log2() - octave) * DEVIATION_STEPS, true));
        let unit = deviation_unit(found.variance.sqrt(), texel[3]);
        for (found, expected) in found.deviations.iter().zip(expected.deviations) {
            let most = 63.0 * unit; // deviations end there
            let error = found - expected.clamp(-most, most);
            let off = if error == 0.0 { 0.0 } else { error / unit };
            steps.push((1, off, expected.abs() < most - unit));
        }
        if steps.iter().any(|(_, off, _)| off.is_nan() || off.abs() > ONE_STEP) {
            wrong += 1;
            continue;
        }
        for (kind, off, _) in steps.into_iter().filter(|&(_, _, free)| free) {
            sums[kind] += off;
            counts[kind] += 1.0;
        }
    }
    NoiseDifference {
        wrong: wrong as f64 / words.len() as f64,
        drift: std::array::from_fn(|k| sums[k] / f64::max(counts[k], 1.0)),
    }
}

/// What the models say of a pixel.
#[derive(Debug, Clone, Copy)]
pub struct Prediction {
    pub signal: [f64; 3],
    pub noise_gain: f64,
    /// < 0 where no model reaches.
    pub relative_noise: f64,
}

/// Steps of the logarithm of the relative noise, per octave.
pub const RELATIVE_NOISE_STEPS: f64 = 254.0 / 26.0;
pub const LEAST_RELATIVE_NOISE_OCTAVE: f64 = -15.0;

impl Prediction {
    pub const NONE: Self = Self { signal: [0.0; 3], noise_gain: 0.0, relative_noise: -1.0 };

    pub fn is_known(&self) -> bool {
        self.relative_noise >= 0.0
    }

    pub fn unpack([low, high]: [u32; 2]) -> Self {
        let half = |bits: u32| f64::from(f16::from_bits(bits as u16));
        let code = f64::from(high >> 24);
        let octave = (code - 1.0) / RELATIVE_NOISE_STEPS + LEAST_RELATIVE_NOISE_OCTAVE;
        Self {
            signal: [half(low), half(low >> 16), half(high)],
            noise_gain: f64::from(high >> 16 & 255) / 255.0,
            relative_noise: if code == 0.0 { -1.0 } else { octave.exp2() },
        }
    }

    /// Squared standard error of a temporal mean, with a prior sample as noisy as the window's.
    pub fn error_of_mean(&self, variance: f64, count: f64) -> f64 {
        let prior = self.relative_noise * luminance(self.signal).powi(2);
        (self.noise_gain * variance * count + prior) / (count + 1.0) / count
    }
}

/// Mean error of values that are rounded at random to half floats, in units of their last place.
pub fn half_drift(found: &[[f64; 4]], expected: &[[f64; 4]]) -> f64 {
    let pairs = found.iter().zip(expected).flat_map(|(f, e)| (0..3).map(|c| (f[c], e[c])));
    // Smaller ones are subnormal; what is no rounding error is for others to find.
    let steps = pairs.filter(|(_, e)| *e > 1e-4).map(|(f, e)| (f - e) / (e.log2().floor() - 10.0).exp2());
    let steps: Vec<f64> = steps.filter(|off| off.abs() < 1.1).collect();
    steps.iter().sum::<f64>() / steps.len() as f64
}
