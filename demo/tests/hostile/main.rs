//! Hostile files: mutated captures and scenes never lead to a panic, a hang, a read outside their folder or memory without bound.
//!
//! The fuzz targets (`fuzz.rs`) start from whole files built here and change their JSON, bytes and paths. They are the same in
//! every run; a failure prints the seed and the case. For longer or other runs:
//!
//! - `QUELL_FUZZ_CASES=20` runs 20 times as many cases (once is 15 to 40 seconds on two cores),
//! - `QUELL_FUZZ_SEED=7` starts elsewhere (0),
//! - `QUELL_FUZZ_ONLY=1234` runs that case of each target and keeps its folder, for a look at a failure.
//!
//! E.g. `QUELL_FUZZ_CASES=100 cargo test -p quell-demo --test hostile fuzz`. What was found has a test of its own in
//! `captures.rs` and `scenes.rs`; `harness_tests.rs` shows that the harness catches what it is for.

mod allocator;
#[path = "../binary/mod.rs"]
mod binary;
mod captures;
mod command_line;
mod files;
mod fuzz;
mod harness;
mod harness_tests;
mod mutate;
mod oracle;
mod scenes;
mod seeds;

#[global_allocator]
static ALLOCATOR: allocator::Counting = allocator::Counting;
