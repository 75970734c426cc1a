#!/usr/bin/env bash
# Formatting, lints and tests of quell-bevy, on the CPU adapter. Builds bevy, which takes a while.
# Arguments go to `cargo test`.
set -euo pipefail
cd "$(dirname "$0")"
# shellcheck source=demo/setup.sh
. ../setup.sh
setup cpu
export WGPU_ADAPTER_NAME=${WGPU_ADAPTER_NAME:-llvmpipe}
# Bevy states a newer Rust than it needs.
cargo=(--locked --ignore-rust-version)
cargo fmt --check
cargo clippy --quiet --all-targets "${cargo[@]}" -- -D warnings
cargo test "${cargo[@]}" "$@"
