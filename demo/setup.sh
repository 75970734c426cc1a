# Sourced by demo/run.sh and tests/run.sh: installs what a bare Debian or Ubuntu machine lacks, and says so where it cannot.
# shellcheck shell=bash

fail() {
    echo "error: $*" >&2
    exit 1
}

# The command, as root where that is possible.
as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; elif command -v sudo >/dev/null; then sudo -n "$@"; else return 1; fi
}

# install_for REASON PACKAGE...
install_for() {
    local reason=$1
    shift
    echo "installing $* ($reason)"
    if ! command -v apt-get >/dev/null; then
        fail "$reason: needs the equivalent of Debian's packages: $*"
    fi
    as_root apt-get update -qq >/dev/null 2>&1 || true
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq "$@" >/dev/null ||
        fail "$reason: please run: sudo apt-get install $*"
}

has_vulkan_driver() { # NAME_PATTERN
    ldconfig -p | grep -q 'libvulkan\.so\.1' &&
        find /usr/share/vulkan/icd.d /etc/vulkan/icd.d -name "$1" 2>/dev/null | grep -q .
}

has_browser() { # under one of the names that demo/tests/browser looks for
    command -v chromium || command -v chromium-browser || command -v google-chrome || command -v google-chrome-stable
} >/dev/null

# What tests/portability needs besides: the browser's validator runs in Node, and Debian's Chromium has another Vulkan driver. Each
# is looked for by itself, because other packages than Debian's may have brought it.
setup_portability() {
    command -v node >/dev/null || install_for "Node, for the browser's shader validator" nodejs
    command -v npm >/dev/null || install_for "npm, for the browser's shader validator" npm
    has_swiftshader || install_for "SwiftShader, to compare drivers" chromium-common
}

has_swiftshader() { # where tests/portability/drivers.rs looks for it
    local folder
    [ -z "${QUELL_SWIFTSHADER_ICD:-}" ] || return 0
    for folder in /usr/lib/chromium /usr/lib64/chromium /usr/lib/chromium-browser /usr/lib64/chromium-browser /opt/google/chrome; do
        [ ! -f "$folder/vk_swiftshader_icd.json" ] || return 0
    done
    return 1
}

setup() { # any | cpu: which Vulkan driver will do
    command -v cargo >/dev/null || export PATH="$HOME/.cargo/bin:$PATH"
    command -v cargo >/dev/null || fail "cargo not found; install Rust from https://rustup.rs"
    command -v c++ >/dev/null || install_for "a C++ compiler, for the FLIP metric" g++
    local driver='*.json'
    [ "$1" = cpu ] && driver='lvp_icd*.json'
    has_vulkan_driver "$driver" || install_for "a Vulkan driver" libvulkan1 mesa-vulkan-drivers
    # Vulkan loaders ask for it even without a display.
    if [ -z "${XDG_RUNTIME_DIR:-}" ]; then
        XDG_RUNTIME_DIR=$(mktemp -d)
        export XDG_RUNTIME_DIR
    fi
}
