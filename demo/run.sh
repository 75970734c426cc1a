#!/usr/bin/env bash
# The walkthrough: sets up what is missing, builds, and opens a window; without a display it renders headless into out/walk.
# Arguments go to quell-demo: `demo/run.sh --help` lists them.
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=demo/setup.sh
. demo/setup.sh
setup any
exec cargo run --quiet --release --locked -p quell-demo -- "$@"
