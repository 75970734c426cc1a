#!/usr/bin/env bash
# All tests: sets up what is missing, then the library's suite and the demo's, on the CPU adapter.
# Arguments go to `cargo test`, e.g. `tests/run.sh -p quell twins`.
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=demo/setup.sh
. demo/setup.sh
setup cpu
has_browser || install_for "a browser, for the test of the report's page" chromium
setup_portability
export QUELL_ADAPTER=${QUELL_ADAPTER:-llvmpipe}
[ $# -gt 0 ] || set -- --workspace
exec cargo test --locked "$@"
