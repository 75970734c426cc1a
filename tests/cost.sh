#!/usr/bin/env bash
# Writes tests/cost.md: what a frame costs, as far as it can be known without a GPU. Seconds, once compiled.
# Says what is worse and what is better than it was; a spilled register fails.
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=demo/setup.sh
. demo/setup.sh
setup cpu
has_vulkan_driver 'radeon_icd*' || install_for "RADV, whose compiler is asked" mesa-vulkan-drivers
QUELL_COST_WRITE=1 exec cargo test --locked -p quell --test cost -- --nocapture "$@"
