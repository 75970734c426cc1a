//! What the frames that were checked add up to.

use super::suspicion::{
    GEOMETRY, LIGHT, MOTION, RATIOS, REFLECTION_WORDS, SLOPE_ONE, STATISTICS, SUSPICION_WORDS,
};
use std::fmt;

/// The numbers that findings are made of, summed over frames. Displays as one line for each suspicion.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    pub(super) frames: u32,
    /// First those of [`GEOMETRY`], then those of [`MOTION`].
    pub(super) votes: Vec<Votes>,
    /// As [`LIGHT`].
    pub(super) light: [u64; LIGHT.len()],
    pub(super) reflection: [u64; REFLECTION_WORDS],
    /// Of albedo as given, and of albedo decoded from sRGB.
    pub(super) slopes: [Slope; 2],
}

/// What pixels that could tell say about a suspicion.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Votes {
    /// Pixels that could tell.
    pub told: u64,
    /// In how many of them what was given holds.
    pub given: u64,
    /// In how many the suspicion holds.
    pub meant: u64,
    /// Frames with such pixels.
    pub frames: u32,
}

/// How much faster than albedo radiance grows, as a power, with the scatter from frame to frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Slope {
    frames: u32,
    sum: f64,
    weight: f64,
    squares: f64,
    products: f64,
    weight_squares: f64,
}

/// Pixels of a frame that make it count as one that told.
const LEAST_OF_FRAME: u32 = 20;

impl Votes {
    pub fn given_share(&self) -> f64 {
        self.given as f64 / self.told.max(1) as f64
    }

    pub fn meant_share(&self) -> f64 {
        self.meant as f64 / self.told.max(1) as f64
    }
}

impl Slope {
    fn add(&mut self, slope: f64, weight: f64) {
        self.frames += u32::from(weight > 0.0);
        self.sum += slope;
        self.weight += weight;
        self.squares += slope * slope;
        self.products += slope * weight;
        self.weight_squares += weight * weight;
    }

    /// 0 where radiance goes with albedo.
    pub fn value(&self) -> f64 {
        self.sum / self.weight.max(f64::MIN_POSITIVE)
    }

    /// Standard error of the value; none of a single frame.
    pub fn error(&self) -> Option<f64> {
        let value = self.value();
        let squares = self.squares - 2.0 * value * self.products + value * value * self.weight_squares;
        let frames = f64::from(self.frames);
        (self.frames > 1).then(|| (squares.max(0.0) * frames / (frames - 1.0)).sqrt() / self.weight)
    }

    /// Pixels times the variance of the logarithm of their albedo.
    pub fn weight(&self) -> f64 {
        self.weight
    }
}

impl Default for Evidence {
    fn default() -> Self {
        Self {
            frames: 0,
            votes: vec![Votes::default(); GEOMETRY.len() + MOTION.len()],
            light: [0; LIGHT.len()],
            reflection: [0; REFLECTION_WORDS],
            slopes: [Slope::default(); 2],
        }
    }
}

impl Evidence {
    /// Adds a frame's words; nothing where they are not as many as the WGSL counts.
    pub(super) fn add(&mut self, words: &[u32]) {
        if words.len() != STATISTICS {
            return;
        }
        self.frames += 1;
        let (of_suspicions, others) = words.split_at(SUSPICION_WORDS * self.votes.len());
        for (votes, words) in self.votes.iter_mut().zip(of_suspicions.chunks_exact(SUSPICION_WORDS)) {
            votes.told += u64::from(words[0]);
            votes.given += u64::from(words[1]);
            votes.meant += u64::from(words[2]);
            votes.frames += u32::from(words[0] >= LEAST_OF_FRAME);
        }
        let (light, reflection) = others.split_at(LIGHT.len());
        let sum = |sums: &mut [u64], words: &[u32]| {
            sums.iter_mut().zip(words).for_each(|(sum, &word)| *sum += u64::from(word));
        };
        sum(&mut self.light, light);
        sum(&mut self.reflection, reflection);
        let slopes = light[LIGHT.len() - 4..].chunks_exact(2);
        for (slope, words) in self.slopes.iter_mut().zip(slopes) {
            // The first of the two is signed.
            slope.add(f64::from(words[0].cast_signed()) / SLOPE_ONE, f64::from(words[1]) / SLOPE_ONE);
        }
    }

    /// A word of [`LIGHT`].
    pub(super) fn light(&self, name: &str) -> u64 {
        LIGHT.iter().zip(self.light).find(|(known, _)| **known == name).map_or(0, |(_, count)| count)
    }

    /// Reflected rays that met something; of these, those whose distance was right from the eye; and by the ratio of given to
    /// found distance, in quarter octaves.
    pub(super) fn reflected(&self) -> (u64, u64, &[u64]) {
        (self.reflection[0], self.reflection[1], &self.reflection[2..])
    }
}

/// Log2 of the ratio of a place in the histogram of hit distances.
pub(super) fn octaves(place: f64) -> f64 {
    (place - (RATIOS / 2) as f64) / 4.0
}

impl fmt::Display for Evidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:24} {:>10} {:>8} {:>10}  over {} frames",
            "suspicion", "pixels", "given", "suspicion", self.frames
        )?;
        for (suspicion, votes) in GEOMETRY.iter().chain(&MOTION).zip(&self.votes) {
            let (given, meant) = (100.0 * votes.given_share(), 100.0 * votes.meant_share());
            writeln!(f, "{:24} {:>10} {given:>6.1} % {meant:>8.1} %", suspicion.name, votes.told)?;
        }
        for (name, count) in LIGHT.iter().zip(&self.light[..LIGHT.len() - 4]) {
            writeln!(f, "{name:24} {count:>10}")?;
        }
        for (name, slope) in ["albedo", "albedo, decoded"].iter().zip(&self.slopes) {
            let (value, error, weight) = (slope.value(), slope.error().unwrap_or(f64::NAN), slope.weight());
            writeln!(f, "{name:24} {weight:>10.0} slope {value:.3}, standard error {error:.3}")?;
        }
        let (met, along, ratios) = self.reflected();
        writeln!(f, "{:24} {met:>10} reflected, {along} as from the eye", "hit distances")?;
        for (place, count) in ratios.iter().enumerate().filter(|(_, count)| 20 * **count > met) {
            writeln!(f, "  {:>+6.2} octaves {count:>18}", octaves(place as f64))?;
        }
        Ok(())
    }
}
