#!/usr/bin/env bash
# Runs the example on a machine without a GPU: Debian trixie's Vulkan driver for CPUs has ray queries, so Solari works in it, slowly.
#
#   demo/bevy/solari.sh FOLDER [options of the example]
#
# Sets trixie up in FOLDER (650 MB) where it is not there yet, and leaves pictures in FOLDER/out. Builds as who you are; what needs root
# is done by sudo.
set -euo pipefail
source=$(cd "$(dirname "$0")" && pwd)
# shellcheck source=demo/setup.sh
. "$source/../setup.sh"
[ $# -gt 0 ] || fail "expected a folder, as in: $0 /tmp/solari --scene court"
mkdir -p "$1"
folder=$(cd "$1" && pwd)
shift
setup any
as_root true || fail "needs root, or sudo without a password, to set up a system in a folder and run in it"

root=$folder/trixie
if [ ! -e "$root/complete" ]; then
    command -v debootstrap >/dev/null || [ -x /usr/sbin/debootstrap ] || install_for "a system with newer drivers" debootstrap
    as_root rm -rf "$root"
    as_root env PATH="$PATH:/usr/sbin:/sbin" debootstrap --variant=minbase --include=libvulkan1,mesa-vulkan-drivers \
        trixie "$root" >"$folder/debootstrap.log" || fail "debootstrap failed; see $folder/debootstrap.log"
    as_root touch "$root/complete"
fi

cd "$source"
binary=$(cargo build --locked --ignore-rust-version --example solari --message-format json-render-diagnostics |
    sed -n 's/.*"executable":"\([^"]*solari\)".*/\1/p')
[ -x "$binary" ] || fail "cargo built no example; its messages say why"
as_root rm -rf "$root/quell"
as_root mkdir -p "$root/quell/out"
as_root cp "$binary" "$root/quell/solari"
as_root chroot "$root" env BEVY_ASSET_ROOT=/quell XDG_RUNTIME_DIR=/tmp /quell/solari --out /quell/out "$@" ||
    fail "the example failed in $root (it needs the C library of trixie, 2.41, or an older one)"
mkdir -p "$folder/out"
cp -r "$root/quell/out/." "$folder/out"
echo "and in $folder/out outside of it"
