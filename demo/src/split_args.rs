//! On the command line: what of a frame quell gets apart.

use crate::gbuffer::Split;
use clap::Args;

#[derive(Debug, Clone, Copy, Default, Args)]
pub struct SplitArgs {
    /// What quell gets apart of what left the first hit through its specular lobe; the other methods get combined radiance
    #[arg(long, value_enum, value_name = "PARTS", default_value_t)]
    split: Split,
    /// As --split none
    #[arg(long, conflicts_with = "split")]
    no_split: bool,
}

impl SplitArgs {
    pub fn split(self) -> Split {
        if self.no_split { Split::None } else { self.split }
    }
}
