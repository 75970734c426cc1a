#!/usr/bin/env bash
# What a machine with a GPU tells of quell in some minutes: a page, its numbers as JSON. Needs no display and no network, and with a
# binary that was built elsewhere (cargo build --release -p quell-demo) no Rust:
#     demo/gpu.sh FOLDER [BINARY [OPTIONS OF quell-demo measure]]
set -euo pipefail
[ $# -gt 0 ] || { echo "usage: demo/gpu.sh FOLDER [BINARY [OPTIONS]]" >&2; exit 2; }
out=$(realpath -m "$1")
if [ $# -gt 1 ]; then
    [ -f "$2" ] && [ -x "$2" ] || { echo "error: $2: not a program that can be run" >&2; exit 1; }
    # Vulkan loaders ask for it even without a display.
    export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$(mktemp -d)}"
    exec "$2" measure --out "$out" "${@:3}"
fi
exec "$(dirname "$0")/run.sh" measure --out "$out"
