//! Images to draw from: every format of the contract, sane and hostile contents.

use crate::gpu::{blank, upload};
use rand::{Rng, rngs::StdRng, seq::IndexedRandom};
use wgpu::TextureFormat as Format;

/// Larger than any frame, so that viewports have room.
pub const SIZE: [u32; 2] = [128, 112];

/// What pixels are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    Sane,
    Zero,
    NotANumber,
    Infinite,
    NegativeInfinite,
    Negative,
    Huge,
    Denormal,
    /// All of these, pixel by pixel.
    Any,
}

impl Content {
    pub const HOSTILE: [Self; 8] = [
        Self::Zero,
        Self::NotANumber,
        Self::Infinite,
        Self::NegativeInfinite,
        Self::Negative,
        Self::Huge,
        Self::Denormal,
        Self::Any,
    ];

    pub fn number(self, random: &mut StdRng) -> f32 {
        match self {
            Self::Sane => random.random_range(0.0..4.0),
            Self::Zero => 0.0,
            Self::NotANumber => f32::from_bits(random.random_range(0x7f80_0001..0x7fff_ffff)),
            Self::Infinite => f32::INFINITY,
            Self::NegativeInfinite => f32::NEG_INFINITY,
            Self::Negative => -random.random_range(0.0f32..1e4),
            Self::Huge => random.random_range(1e3f32..3e38),
            Self::Denormal => f32::from_bits(random.random_range(1..0x007f_ffff)),
            Self::Any => {
                let kinds =
                    [Self::Sane, Self::Zero, Self::NotANumber, Self::Infinite, Self::NegativeInfinite];
                let others = [Self::Negative, Self::Huge, Self::Denormal, Self::Sane];
                let all = [&kinds[..], &others[..]].concat();
                all.choose(random).copied().unwrap_or(Self::Sane).number(random)
            }
        }
    }
}

/// Views by what they can stand for.
pub struct Pool {
    pub colours: Vec<wgpu::TextureView>,
    pub normals: Vec<wgpu::TextureView>,
    pub scalars: Vec<wgpu::TextureView>,
    pub motions: Vec<wgpu::TextureView>,
    pub ids: Vec<wgpu::TextureView>,
    pub counts: Vec<wgpu::TextureView>,
    /// Are written.
    pub shown: wgpu::TextureView,
    pub map: wgpu::TextureView,
}

/// An image of this format whose every number is of this content.
pub fn image(size: [u32; 2], format: Format, content: Content, random: &mut StdRng) -> wgpu::TextureView {
    let pixels = (size[0] * size[1]) as usize;
    let floats = |channels: usize, random: &mut StdRng| -> Vec<f32> {
        (0..channels * pixels).map(|_| content.number(random)).collect()
    };
    let halves = |channels: usize, random: &mut StdRng| -> Vec<half::f16> {
        floats(channels, random).into_iter().map(half::f16::from_f32).collect()
    };
    match format {
        Format::R32Float => upload(size, format, &floats(1, random)),
        Format::Rg32Float => upload(size, format, &floats(2, random)),
        Format::Rgba32Float => upload(size, format, &floats(4, random)),
        Format::R16Float => upload(size, format, &halves(1, random)),
        Format::Rg16Float => upload(size, format, &halves(2, random)),
        Format::Rgba16Float => upload(size, format, &halves(4, random)),
        // Every bit pattern of the others is a number.
        _ => {
            let texel = format.block_copy_size(None).unwrap() as usize;
            let bytes: Vec<u8> = (0..texel * pixels).map(|_| random.random()).collect();
            upload(size, format, &bytes)
        }
    }
}

impl Pool {
    pub fn new(random: &mut StdRng) -> Self {
        let mut of = |formats: &[Format]| -> Vec<wgpu::TextureView> {
            let contents = [Content::Sane, Content::Sane, Content::Any].into_iter().chain(Content::HOSTILE);
            let pairs = contents.zip(formats.iter().cycle());
            pairs.map(|(content, &format)| image(SIZE, format, content, random)).collect()
        };
        Self {
            colours: of(&[Format::Rgba16Float, Format::Rgba16Float, Format::Rgba16Float]),
            normals: of(&[Format::Rgba16Float, Format::Rgba16Float]),
            scalars: of(&[Format::R32Float]),
            motions: of(&[Format::Rg32Float, Format::Rgba16Float, Format::Rg16Float]),
            ids: of(&[Format::R32Uint]),
            counts: of(&[Format::R8Uint, Format::R32Uint]),
            shown: blank(SIZE, Format::Rgba16Float),
            map: blank(SIZE, Format::R32Uint),
        }
    }
}
