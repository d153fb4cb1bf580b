#!/bin/sh
# foveactl compare: its output for people and for scripts, and what it refuses. FLIP's values have a test of their own
# (renderer_metric).
. "$(dirname "$0")/common.sh"
make_room

"$fovead" --scene room.obj --size 128x64 --until 16spp --save good.exr >/dev/null 2>&1
"$fovead" --scene room.obj --size 128x64 --until 2spp --save noisy.exr >/dev/null 2>&1

near 0 good.exr good.exr
near 0.3 good.exr noisy.exr --map map.png
grep -q '"metric": "HDR-FLIP"' near.json && grep -q '"relative_rmse": [0-9]' near.json &&
    grep -q '"psnr_db": null' near.json || fail "$(cat near.json)"
! (near 0.05 good.exr noisy.exr) 2>near.err || fail "a picture of 2 paths per pixel passes for one of 16"
grep -q 'FLIP of good.exr noisy.exr is 0\.[0-9]*, where at most 0.05' near.err || fail "$(cat near.err)"
near 0.4 good.exr noisy.exr --ldr --ppd 20
grep -q '"metric": "LDR-FLIP"' near.json && grep -q '"psnr_db": [0-9]' near.json || fail "$(cat near.json)"

# The map shows the difference: it differs from the black map of equal pictures, and holds values for a display.
"$foveactl" compare good.exr good.exr --map black.png >same.txt
grep -q '^HDR-FLIP   0.000000 ' same.txt && grep -q '^largest    0.000000' same.txt || fail "$(cat same.txt)"
"$foveactl" compare black.png map.png >maps.txt
grep -q '^LDR-FLIP   0\.[1-9]' maps.txt && grep -q '^PSNR ' maps.txt || fail "$(cat maps.txt)"
"$foveactl" compare good.exr map.png >mixed.txt
grep -q 'values for a display' mixed.txt && grep -q '^LDR-FLIP ' mixed.txt || fail "$(cat mixed.txt)"

# bad WORD ARGUMENT...: refused, without a word on the pictures.
bad() {
    word=$1
    shift
    refused "$word" "$foveactl" compare "$@"
    [ ! -s refused.out ] || fail "it printed: $(cat refused.out)"
}
bad missing.exr missing.exr good.exr
bad missing.exr good.exr missing.exr
echo "not an image" >words.exr
bad words.exr good.exr words.exr
bad "$place" good.exr "$place"
head -c 2000 good.exr >truncated.exr
bad truncated.exr good.exr truncated.exr
"$fovead" --scene room.obj --size 256x128 --until 1spp --save large.exr >/dev/null 2>&1
bad 'good.exr is 128x64, but large.exr is 256x128' good.exr large.exr
(printf 'P5 65537 1 255\n' && head -c 65537 /dev/zero) >wide.pgm
bad 65537x1 wide.pgm wide.pgm
printf 'PF\n2 1\n-1.0\n\0\0\200\077\0\0\200\077\0\0\200\077\0\0\200\077\0\0\200\077\0\0\300\177' >nan.pfm
bad 'a pixel of the reference is not finite, at 1,0' nan.pfm nan.pfm
for ppd in 0 0.9 301 nan none; do bad --ppd good.exr noisy.exr --ppd "$ppd"; done
bad noending good.exr noisy.exr --map noending
bad absent/map.png good.exr noisy.exr --map absent/map.png
bad 'usage: foveactl compare REFERENCE TEST' good.exr
bad '--view does not go with compare' good.exr noisy.exr --view 0,0,90
refused '--ldr does not go with stats' "$foveactl" stats --ldr
