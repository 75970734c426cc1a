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
        tiles+=("(" "$work/$2" -crop "$crop" +repage -filter point -resize "$percent%" -set label "$1" ")")
        shift 2
    done
    montage -background '#181818' -fill white -pointsize 13 "${tiles[@]}" -tile "${columns}x" -geometry +3+3 -strip \
        -define png:compression-level=9 "png24:$pictures/$picture.png"
}

record sun --fps 15 --frames 16 --reference 96 --reference-frames 15
record lamp-off --start 8 --fps 15 --frames 26 --reference 64 --reference-frames 24
record bars --start 16 --fps 15 --frames 16 --reference 96 --reference-frames 15
record mirrors --start 29.2 --fps 15 --frames 17 --reference 96 --reference-frames 16
record lamp-on --start 11.4 --fps 15 --frames 20 --reference 64 --reference-frames 10
# A view and a time that stand still.
record still --start 10.5 --fps 1e6 --frames 64 --reference 256 --reference-frames 63
record quarter --fps 15 --frames 16 --spp 0.25

replay sun quell
replay sun noisy --method none
replay sun combined --no-split
replay sun models --no-split --no-mix
replay sun fixed1 --no-split --no-mix --windows fixed:1
replay sun fixed3 --no-split --no-mix --windows fixed:3
replay sun uniform4 --no-split --no-mix --centres uniform:4
replay sun uniform1 --no-split --no-mix --centres uniform:1
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

debug sun sun 15
debug sun sun-sign 15 --wrong motion-direction --views HistoryLength
debug sun sun-unit 15 --wrong motion-unit --views HistoryLength
debug sun sun-zero 15 --wrong no-motion --views HistoryLength
debug lamp-off lamp-off 24 --views HistoryLength
debug bars bars 15 --views HistoryLength
debug mirrors mirrors 16 --views HistoryLength
debug lamp-on lamp-on 10 --views HistoryLength
debug lamp-on lamp-em 18 --views Prediction
debug lamp-on lamp-noem 18 --wrong no-emission --views Prediction
debug still still 63 --views HistoryLength

# How it works
side steps 120x80+90+95 300 2 "one sample per pixel" sun-noisy/frame_0015.png "TemporalMean" views-sun/TemporalMean.png \
    "Prediction" views-sun/Prediction.png "output" views-sun/output.png
side history 320x180+0+0 100 2 "Motion" views-sun/Motion.png "HistoryLength" views-sun/HistoryLength.png
side windows 320x180+0+0 100 2 "Windows" views-sun/Windows.png "SurfaceId" views-sun/SurfaceId.png
side mix 320x180+0+0 100 3 "MixWeight" views-sun/MixWeight.png "PredictedError" views-sun/PredictedError.png \
    "OutputError" views-sun/OutputError.png

# Troubleshooting
side wrong 150x84+30+60 150 4 "right" views-sun/output.png "wrong sign" views-sun-sign/output.png \
    "wrong unit" views-sun-unit/output.png "no motion" views-sun-zero/output.png \
    "HistoryLength" views-sun/HistoryLength.png "" views-sun-sign/HistoryLength.png \
    "" views-sun-unit/HistoryLength.png "" views-sun-zero/HistoryLength.png

# Settings
side innovation 110x70+0+85 300 2 "as it is" lamp-off-quell/frame_0024.png "no innovation" lamp-off-constant/frame_0024.png \
    "no innovation, max_history 8" lamp-off-short/frame_0024.png "reference" views-lamp-off/reference.png
side mix_temporal_mean 110x62+80+116 300 3 "as it is" sun-combined/frame_0015.png "models alone" sun-models/frame_0015.png \
    "reference" views-sun/reference.png
side firefly_limit 110x62+70+118 300 2 "0.25" lamp-off-firefly-low/frame_0024.png "1" lamp-off-quell/frame_0024.png \
    "infinity" lamp-off-firefly-none/frame_0024.png "reference" views-lamp-off/reference.png
side windows_rule 110x62+80+116 300 3 "Fixed(1)" sun-fixed1/frame_0015.png "MallowsCp" sun-models/frame_0015.png \
    "Fixed(3)" sun-fixed3/frame_0015.png
side centres 110x62+80+116 300 3 "Uniform(4)" sun-uniform4/frame_0015.png "Adaptive" sun-models/frame_0015.png \
    "Uniform(1)" sun-uniform1/frame_0015.png
side budget 110x62+80+116 300 3 "Unlimited" sun-combined/frame_0015.png "Models(0)" sun-fast/frame_0015.png \
    "reference" views-sun/reference.png
side max_history 110x70+120+0 300 2 "8" still-short/frame_0063.png "32" still-quell/frame_0063.png \
    "1024" still-long/frame_0063.png "reference" views-still/reference.png

# Known failures
side failure_shadows 110x62+80+116 300 3 "one sample per pixel" sun-noisy/frame_0015.png "quell" sun-combined/frame_0015.png \
    "reference" views-sun/reference.png
side failure_thin 64x76+170+54 400 4 "one sample per pixel" bars-noisy/frame_0015.png "quell" bars-quell/frame_0015.png \
    "HistoryLength" views-bars/HistoryLength.png "reference" views-bars/reference.png
side failure_switched 100x62+0+118 300 3 "second frame" lamp-on-quell/frame_0010.png "sixth" lamp-on-quell/frame_0014.png \
    "reference of the second" views-lamp-on/reference.png
side failure_mirrors 130x70+160+8 300 2 "one signal" mirrors-combined/frame_0016.png "with hit distances" mirrors-hit/frame_0016.png \
    "split" mirrors-quell/frame_0016.png "reference" views-mirrors/reference.png
side failure_mirror_noise 80x45+165+35 400 2 "quell" mirrors-quell/frame_0016.png "reference" views-mirrors/reference.png
side failure_spots 110x62+0+110 300 2 "quell" lamp-off-quell/frame_0024.png "reference" views-lamp-off/reference.png
side failure_specks 120x75+30+100 300 2 "quarter of a sample" quarter-noisy/frame_0015.png "quell" quarter-quell/frame_0015.png
side failure_cut 110x70+60+100 300 3 "first frame" sun-quell/frame_0000.png "second" sun-quell/frame_0001.png \
    "fourth" sun-quell/frame_0003.png
side failure_emission 80x56+100+18 400 2 "with emission" views-lamp-em/output.png "without" views-lamp-noem/output.png
