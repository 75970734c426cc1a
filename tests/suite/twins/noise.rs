//! The noise image in f64.

use rand::{Rng, rngs::StdRng};

#[derive(Debug, Clone, Copy, Default)]
pub struct Noise {
    /// Of one sample's luminance.
    pub variance: f64,
    /// Of the temporal mean's luminance; each stands for it.
    pub deviations: [f64; 3],
}

impl Noise {
    pub fn unpack([deviation, a, b, c]: [half::f16; 4]) -> Self {
        Self { variance: f64::from(deviation).powi(2), deviations: [a, b, c].map(f64::from) }
    }

    /// The values that the image holds.
    pub fn packed(&self) -> [f64; 4] {
        let [a, b, c] = self.deviations;
        [self.variance.sqrt(), a, b, c]
    }

    /// Variance of the temporal mean.
    pub fn found(&self) -> f64 {
        self.deviations.iter().map(|d| d * d).sum::<f64>() / 3.0
    }
}

/// As half floats hold it.
pub fn random_noise(random: &mut StdRng, pixels: usize) -> Vec<[half::f16; 4]> {
    let texel = |random: &mut StdRng| {
        let deviations: [f32; 3] = std::array::from_fn(|_| random.random_range(-0.5..0.5));
        let deviation = random.random_range(0.0..1.4_f32);
        [deviation, deviations[0], deviations[1], deviations[2]].map(half::f16::from_f32)
    };
    (0..pixels).map(|_| texel(random)).collect()
}

pub fn unpack(texels: &[[half::f16; 4]]) -> Vec<Noise> {
    texels.iter().copied().map(Noise::unpack).collect()
}
