#!/usr/bin/env bash
# Makes the pictures of these pages anew, from nothing: captures of the demo's scenes, denoised in several ways, cut and put side by
# side. Needs ImageMagick (`apt-get install imagemagick`), besides what the demo needs. Half an hour on a CPU driver with two
# cores. What is in out/docs already is not made again.
#
# `demo/docs/pictures.sh` makes all; QUELL_DEMO and QUELL_VIEWS may name binaries that are built already.
set -euo pipefail
cd "$(dirname "$0")/../.."
work=out/docs
pictures=demo/docs/pictures
demo=${QUELL_DEMO:-./demo/run.sh}
views=${QUELL_VIEWS:-cargo run --quiet --release --locked -p quell-demo --example debug_views --}
command -v montage > /dev/null || { echo "ImageMagick is missing: apt-get install imagemagick" >&2; exit 1; }
mkdir -p "$work" "$pictures"

# record NAME OPTION...
record() {
    [ -e "$work/$1/capture.json" ] || $demo record --overwrite --out "$work/$1" "${@:2}"
}

# replay CAPTURE NAME OPTION... denoises a capture into $work/CAPTURE-NAME.
replay() {
    [ -e "$work/$1-$2/done" ] || { $demo replay "$work/$1" --out "$work/$1-$2" "${@:3}" && touch "$work/$1-$2/done"; }
}

# debug CAPTURE NAME FRAME OPTION... writes the debug views of a frame into $work/views-NAME.
debug() {
    [ -e "$work/views-$2/output.png" ] || $views "$work/$1" --frame "$3" --out "$work/views-$2" "${@:4}"
}

# side PICTURE CROP PERCENT COLUMNS LABEL IMAGE... cuts the same part of some images, enlarges it, and puts them side by side.
side() {
    local picture=$1 crop=$2 percent=$3 columns=$4 tiles=()
    shift 4
    while [ $# -gt 0 ]; do
        tiles+=(-label "$1" "(" "$work/$2" -crop "$crop" +repage -filter point -resize "$percent%" ")")
        shift 2
    done
    montage -background '#181818' -fill white -font DejaVu-Sans -pointsize 13 "${tiles[@]}" -tile "${columns}x" -geometry +3+3 \
        -strip -colors 255 "png8:$pictures/$picture.png"
}

record sun --fps 15 --frames 16 --reference 96 --reference-frames 15
record lamp-off --start 8 --fps 15 --frames 26 --reference 64 --reference-frames 24
record bars --start 16 --fps 15 --frames 16 --reference 96 --reference-frames 15
record mirrors --start 29.2 --fps 15 --frames 17 --reference 96 --reference-frames 16
record lamp-on --start 11.4 --fps 15 --frames 20 --reference 64 --reference-frames 10
# A view and a time that stand still.
record still --start 10.5 --fps 1e6 --frames 64 --reference 256 --reference-frames 63
record quarter --fps 15 --frames 16 --spp 0.25
# The lamp of the hall goes off at 3.5 s, of which the colonnade sees little.
record faint --start 2.7 --fps 15 --frames 24 --reference 64 --reference-frames 14

replay sun quell
replay sun noisy --method none
replay sun accumulate --method accumulate
replay sun svgf --method svgf
replay sun combined --no-split
replay sun models --no-split --no-mix
replay sun fixed1 --no-split --windows fixed:1
replay sun fixed3 --no-split --windows fixed:3
replay sun uniform4 --no-split --centres uniform:4
replay sun uniform1 --no-split --centres uniform:1
replay sun fast --no-split --budget-models 0
replay lamp-off quell
replay lamp-off constant --no-innovation
replay lamp-off short --no-innovation --max-history 8
replay lamp-off firefly-low --firefly-limit 0.25
replay lamp-off firefly-none --firefly-limit inf
replay bars quell
replay bars noisy --method none
replay mirrors quell
replay mirrors hit --split hit-distance
replay mirrors combined --no-split
replay mirrors noisy --method none
replay lamp-on quell
replay still quell
replay still short --max-history 8
replay still long --max-history 1024
replay quarter quell
replay quarter noisy --method none
replay faint quell
