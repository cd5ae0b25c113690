#!/bin/sh
# seen.sh - what `bake` writes into models, seen by others: Khronos' glTF validator, three.js in Chromium (both from npm),
# and Blender. A program that is not there is named and left out; with CI set that is a failure, except for Blender, which
# no package of the test machine brings. Last line: "seen: N passed, N failed, N skipped".
build=${BUILD:-build}
dir=build/seen
passed=0 failed=0 skipped=0
mkdir -p $dir || exit 1
rm -f $dir/*.glb $dir/cornell.json*
leave() {
    echo "  skipped: $1 ($2)"
    skipped=$((skipped + 1))
}
lit() { if node $dir/seen_lit.mjs $dir/"$1".png "$@"; then passed=$((passed + 1)); else failed=$((failed + 1)); fi; }
bake() { "$build/bake" "$@" || { echo "  FAILED: bake $*"; failed=$((failed + 1)); }; }

if command -v node >/dev/null 2>&1; then
    node tests/web/seen_model.mjs $dir/box.glb || exit 1
    bake ao $dir/box.glb -o $dir/box-vertex.glb --set into=vertex --set bent=1
    bake ao $dir/box.glb -o $dir/box-texture.glb --set image_side=256 --set bent=1 --set bits=16
    bake model builtin:knot -o $dir/knot.glb
    bake lights builtin:sky --count 100 -o $dir/sky.glb
    bake lights builtin:sky --count 100 -o $dir/sky.json
    if "$build/render" --list | grep -q '^  reference.*needs Embree'; then leave 'bake light' 'no Embree'
    else
        bake light $dir/box.glb -o $dir/box-light.glb --set into=vertex --set samples=16 --set directional=1
        bake model builtin:cornell -o $dir/cornell.glb
        bake probes builtin:cornell --grid 6x6x6 --bounces 4 -o $dir/cornell.json
        rm -f $dir/map-*
        for map in 'float --set maps=exr --set bits=32' 'half --set maps=exr' 'hdr --set maps=hdr'; do
            # shellcheck disable=SC2086
            bake light $dir/box.glb -o $dir/map-${map%% *}.glb --set samples=16 --set image_side=128 ${map#* }
        done
    fi
fi
wanted=
if [ -d $dir/node_modules/three ] && [ -d $dir/node_modules/puppeteer-core ] && [ -d $dir/node_modules/gltf-validator ]; then :
elif command -v npm >/dev/null 2>&1; then
    echo '{ "private": true }' > $dir/package.json
    (cd $dir && npm install --no-audit --no-fund three@0.187 puppeteer-core@25 gltf-validator@2.0.0-dev.3.10 > npm.log 2>&1) ||
        wanted='npm cannot bring them'
else wanted='npm is not installed'; fi
command -v chromium >/dev/null 2>&1 || wanted='chromium is not installed'
command -v node >/dev/null 2>&1 || wanted='node is not installed'
if [ -n "$wanted" ]; then
    leave 'glTF validator, three.js in Chromium' "$wanted"
    [ -z "$CI" ] || failed=$((failed + 1))
else
    cp tests/web/seen.mjs $dir/
    set --
    for file in $dir/box-*.glb; do set -- "$@" $dir/box.glb "$file"; done
    if node $dir/seen.mjs $dir "$@"; then passed=$((passed + $# / 2)); else failed=$((failed + 1)); fi
    # Pictures of docs/: the same with bunny.glb and venice_sunset_1k.hdr (--count 300 --set split_sun=1 --set hemisphere=1), and as it is.
    cp tests/web/seen_lit.mjs $dir/
    lit lights $dir/knot.glb $dir/sky.glb $dir/sky.json
    [ ! -f $dir/cornell.json ] || lit probes $dir/cornell.glb $dir/cornell.json examples/bake/probes.glsl
fi
if [ -f $dir/map-float.glb ] && [ -d $dir/node_modules/three ]; then
    cp tests/web/seen_maps.mjs $dir/
    if node $dir/seen_maps.mjs $dir map-float map-half map-hdr; then passed=$((passed + 2)); else failed=$((failed + 1)); fi
fi
if command -v blender >/dev/null 2>&1; then
    for file in $dir/box-*.glb; do
        if blender -b --python-exit-code 1 --python tests/scripts/seen_blender.py -- "$file" > $dir/blender.log 2>&1; then
            echo "  passed: Blender, $file"
            passed=$((passed + 1))
        else
            echo "  FAILED: Blender, $file"
            grep -i 'error' $dir/blender.log
            failed=$((failed + 1))
        fi
    done
else leave 'Blender' 'not installed'; fi
echo "seen: $passed passed, $failed failed, $skipped skipped"
[ -n "$TOTALS" ] && echo "$passed $failed $skipped" >> "$TOTALS"
[ $failed = 0 ]
