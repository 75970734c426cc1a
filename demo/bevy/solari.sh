#!/usr/bin/env bash
# Runs the example on a machine without a GPU: Debian trixie's Vulkan driver for CPUs has ray queries, so Solari works in it, slowly.
#
#   sudo demo/bevy/solari.sh FOLDER [options of the example]
#
# As root; sets trixie up in FOLDER (300 MB) where it is not there yet, and leaves pictures in FOLDER/out.
set -euo pipefail
source=$(cd "$(dirname "$0")" && pwd)
# shellcheck source=demo/setup.sh
. "$source/../setup.sh"
[ $# -gt 0 ] || fail "expected a folder, as in: sudo $0 /tmp/trixie --scene court"
[ "$(id -u)" = 0 ] || fail "needs root, to set up a system in a folder and run in it"
mkdir -p "$1"
folder=$(cd "$1" && pwd)
shift

setup any
root=$folder/trixie
if [ ! -e "$root/complete" ]; then
    command -v debootstrap >/dev/null || install_for "a system with newer drivers" debootstrap
    rm -rf "$root"
    debootstrap --variant=minbase --include=libvulkan1,mesa-vulkan-drivers trixie "$root" >"$folder/debootstrap.log" ||
        fail "debootstrap failed; see $folder/debootstrap.log"
    touch "$root/complete"
fi

cd "$source"
binary=$(cargo build --locked --ignore-rust-version --example solari --message-format json-render-diagnostics |
    sed -n 's/.*"executable":"\([^"]*solari\)".*/\1/p')
mkdir -p "$root/quell/out"
cp "$binary" "$root/quell/solari"
chroot "$root" env XDG_RUNTIME_DIR=/tmp /quell/solari --out /quell/out "$@"
mkdir -p "$folder/out"
cp -r "$root/quell/out/." "$folder/out"
echo "and in $folder/out outside of it"
