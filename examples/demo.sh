#!/bin/sh
# Scene by scene, the techniques that it was made for beside one reference: out/index.html, which.html and contact.png.
# Left out though render treats them: rsm and ism under skies without walls (little bounces), rsm where many
# small lamps shine (few points for all), csm where all light bounces, shadowfield on what deforms (docs/programs.md).
# Called by `make demo`.
#   BUILD         where the programs are (build)
#   ASSETS        a folder of real models and skies; without it only built-in scenes
#   DEMO_SIZE     384x216; DEMO_SAMPLES of csm 256; DEMO_REFERENCE of the reference 128
#   DEMO_SCENES   which scenes to make, e.g. "cornell knot"; default: all
#   KEPT          a folder of kept references, of which those that show the same are taken (docs/references)
#   REFERENCES    not empty: only prints the references' names and command lines, for tools/references
# The page is written after each scene, so that its first picture can be looked at while the others are drawn.
set -u
BUILD=${BUILD:-build}
OUT=${OUT:-out}
SIZE=${DEMO_SIZE:-384x216}
SAMPLES=${DEMO_SAMPLES:-256}
REFERENCE=${DEMO_REFERENCE:-128}
KEPT=${KEPT-docs/references}
ASSETS=${ASSETS:-}
LIST=$OUT/gallery.tsv
failures=0
total=0 done=0 counting=
mkdir -p "$OUT" || exit 1

say() {         # say FIELD...: a line of the list that build/gallery reads (examples/demo/gallery.h)
    line=$1
    shift
    for field; do line=$(printf '%s\t%s' "$line" "$field"); done
    printf '%s\n' "$line" >> "$LIST"
}

leave() {
    [ -z "$counting" ] || return 0
    echo "demo: left out: $1"
    say left "$1"
}

render() {      # render STEM ARGUMENTS
    stem=$1
    shift
    "$BUILD/render" "$@" --size "$SIZE" --out "$OUT/$stem.pfm" --json "$OUT/$stem.json" && return
    failures=$((failures + 1))
    return 1
}

# group SCENE direct|bounced TITLE ARGUMENTS: the scene, and its reference; rows follow. Before it, times=4 stands for
# four times as many paths, where small lamps or light round corners make the reference noisy.
times=1
# shellcheck disable=SC2086
group() {
    scene=$1 kind=$2 title=$3
    shift 3
    scene_arguments=$*
    reference=
    paths=$((REFERENCE * times))
    times=1
    case " ${DEMO_SCENES:-$scene} " in *" $scene "*) ;; *) scene=; return ;; esac
    bounces=0
    [ "$kind" = bounced ] && bounces=1
    if [ -n "${REFERENCES:-}" ]; then
        printf '%s\t%s\n' "$scene-$kind" "--technique reference $scene_arguments --set bounces=$bounces --size $SIZE"
        scene=
        return
    fi
    if [ -n "$counting" ]; then
        total=$((total + 1)) scene=
        return
    fi
    write_page
    done=$((done + 1))
    echo "demo: $done of $total, after $(($(date +%s) - begun)) s: $title"
    if [ -n "$has_reference" ] && render "$scene-$kind-reference" --technique reference $scene_arguments \
       --set bounces=$bounces --samples "$paths" $kept; then
        reference=$scene-$kind-reference
    fi
    say group "$scene" "$kind" "$title" "$reference"
}

# write_page: of the scenes that are whole
write_page() {
    say scenes "$total" "$done"
    [ $done = 0 ] || "$BUILD/gallery" "$OUT" || failures=$((failures + 1))
}

# row TECHNIQUE cpu|gl REMARK ARGUMENTS: a picture of the group's scene, compared with the reference
# shellcheck disable=SC2086
row() {
    technique=$1 backend=$2 remark=$3
    shift 3
    [ -n "$scene" ] || return
    [ "$backend" = gl ] && [ -z "$has_gl" ] && return
    own=$scene-$kind-$technique-$backend
    rm -f "$OUT/$own"-*
    [ "$backend" = gl ] && set -- --set warm_up=1 "$@"
    render "$own" --technique "$technique" --backend "$backend" $scene_arguments "$@" || return
    if [ -n "$reference" ]; then
        "$BUILD/compare" "$OUT/$own.pfm" "$OUT/$reference.pfm" --diff "$OUT/$own-diff.png" > "$OUT/$own-compare.json" ||
            failures=$((failures + 1))
    fi
    say row "$technique" "$backend" "$remark" "$own"
}

maps="--samples $SAMPLES --set side=64 --set filter=roulette"       # csm: 4,096 maps an object
few="--samples $SAMPLES --set side=32 --set filter=roulette"        # 1,024
fields="--set position_side=6 --set point_spacing=0.05"

# shellcheck disable=SC2086
scenes() {
group cornell direct "Cornell box: direct light of its lamp" --scene builtin:cornell
row csm cpu "64 places on the lamp" --samples "$SAMPLES"
row csm gl "64 places on the lamp" --samples "$SAMPLES"
row rsm cpu "patches of the lamp" --set only=direct
row ism cpu "points of the lamp as VPLs" --set bounces=0

group cornell bounced "Cornell box: direct and once bounced light" --scene builtin:cornell
row rsm cpu "400 texels a pixel and map"
row rsm gl "interpolated" --set mode=interpolated
row ism cpu "1024 VPLs"

group knot direct "Knot under a sky" --scene builtin:knot
row csm cpu "4,096 maps, roulette" $maps
row csm gl "4,096 maps, roulette" $maps
row shadowfield cpu "harmonics, 4 bands" $fields
row envshadow cpu "256 lights"
row envshadow gl "256 lights"

group knot-sun direct "Knot in the sun" --scene builtin:knot --light sun:0.48,0.8,0.36
row csm cpu "one map of 1024 x 1024" --samples 1
row envshadow cpu "one map"
row rsm cpu "one map" --set only=direct
row ism cpu "one map" --set bounces=0

group plant direct "Plant under a sky: thin sheets" --scene builtin:plant
row csm cpu "4,096 maps, roulette" $maps
row shadowfield cpu "harmonics, 4 bands" $fields
row envshadow cpu "256 lights"
row envshadow gl "256 lights"

group chess direct "Chess under an overcast sky: 32 instances of six pieces" \
    --scene builtin:chess --env builtin:overcast
row csm cpu "1,024 maps a piece, roulette" $few
row shadowfield cpu "harmonics, 4 bands" $fields
row shadowfield gl "harmonics, 4 bands" $fields
row envshadow cpu "256 lights"

relit="--env builtin:overcast --set env_scale=0.3 --set lamp_count=4 --frames 8"
times=4
group chess-lamps direct "Chess under a sky and four circling lamps: the eighth frame of a game" \
    --scene builtin:chess $relit
row csm cpu "4 x 4 places on a lamp" --samples "$SAMPLES" --set side=16 --set filter=roulette --set light_side=4 \
    --set light_map_side=128
row shadowfield cpu "harmonics, 4 bands" $fields

times=4
group chess-relit direct "Chess under a sky: only the four lamps move" --scene builtin:chess $relit --set still=1
row shadowfield cpu "harmonics, 4 bands, lazily" $fields --set lazy=1

times=4
group robots direct "Robots with lamps: local lights that move" --scene builtin:robots
row csm cpu "4 x 4 places on a lamp" --samples "$SAMPLES" --set light_side=4 --set light_map_side=128
row shadowfield cpu "harmonics, 4 bands" $fields
row ism cpu "lamps as VPLs" --set bounces=0

group spaceships direct "Spaceships under a sky: large shadows" --scene builtin:spaceships
row csm cpu "4,096 maps an object, roulette" $maps
row shadowfield cpu "wavelets" --set position_side=4 --set point_spacing=0.04 --set basis=haar --set shell_count=12 --set keep=0.02
row envshadow cpu "256 lights"

times=4
group explosion direct "Explosion: a video as the lamp" --scene builtin:explosion
row csm cpu "64 places on the fire" --samples "$SAMPLES" --set light_map_side=128
row shadowfield cpu "harmonics, 4 bands" $fields --set source_position_side=4 --set source_shell_count=8
row ism cpu "points of the fire as VPLs" --set bounces=0

group cloth direct "Cloth in the wind under a sky: deforming sheets" --scene builtin:cloth
row csm cpu "1,024 maps an object, roulette, built for each frame" $few
row envshadow cpu "256 lights"
row envshadow gl "256 lights"

group figure direct "Dressed figure under a sky: deforming" --scene builtin:figure
row csm cpu "1,024 maps an object, roulette, built for each frame" $few
row envshadow cpu "256 lights"

times=4
group uroom bounced "U-shaped room: all light comes round the corner" --scene builtin:uroom
row rsm cpu "400 texels a pixel"
row rsm gl "interpolated" --set mode=interpolated
row ism cpu "1024 VPLs"
row ism gl "1024 VPLs of 2048 points" --set surfel_count=2048

times=4
group corridor bounced "Corridor: a statue lit by a far wall alone" --scene builtin:corridor
row rsm cpu "400 texels a pixel"
row ism cpu "1024 VPLs"

group atrium bounced "Atrium: a million triangles in the sun" --scene builtin:atrium
row rsm cpu "400 texels a pixel of 1024 x 1024" --set side=1024
row ism cpu "1024 VPLs"

if [ -n "$ASSETS" ]; then
    for model in bunny dragon; do
        [ -f "$ASSETS/$model.glb" ] || continue
        group $model direct "$model.glb under a sky" --scene "$ASSETS/$model.glb"
        row csm cpu "4,096 maps, roulette" $maps
        row shadowfield cpu "harmonics, 4 bands" $fields
        row envshadow cpu "256 lights"
    done
    # A measured sky: make assets brings all but the first.
    for sky in venice_sunset_1k sunset studio city courtyard forest interior night sunrise; do
        if [ ! -f "$ASSETS/bunny.glb" ] || [ ! -f "$ASSETS/$sky.hdr" ]; then continue; fi
        group "bunny-$sky" direct "bunny.glb under $sky.hdr" --scene "$ASSETS/bunny.glb" --env "$ASSETS/$sky.hdr"
        row csm cpu "4,096 maps, roulette" $maps
        row envshadow cpu "256 lights"
        break
    done
else
    leave "real models (make assets, or ASSETS=FOLDER)"
fi
}
if [ -n "${REFERENCES:-}" ]; then
    counting=yes
    scenes
    exit 0
fi
rm -f "$LIST"
command="make demo DEMO_SIZE=$SIZE DEMO_SAMPLES=$SAMPLES DEMO_REFERENCE=$REFERENCE"
say run "$command${DEMO_SCENES:+ DEMO_SCENES=\"$DEMO_SCENES\"}${ASSETS:+ ASSETS=...}"
has_reference=yes
if "$BUILD/render" --list | grep -q '^  reference.*needs Embree'; then
    has_reference=
    leave "the reference and what is measured against it (libembree-dev is missing)"
fi
has_gl=yes
if ! "$BUILD/render" --technique rsm --backend gl --scene builtin:uroom --size 16x16 --samples 4 --set side=16 \
     --out "$OUT/probe.pfm" 2> "$OUT/probe.txt"; then
    has_gl=
    leave "rows on OpenGL ($(tail -n 1 "$OUT/probe.txt"))"
fi
rm -f "$OUT/probe.pfm" "$OUT/probe.txt"

kept=
[ -n "$KEPT" ] && [ -f "$KEPT/list.tsv" ] && kept="--kept $KEPT"
say best atrium-bounced-ism-cpu
counting=yes
scenes
counting=
begun=$(date +%s)
scenes
# A model with ambient occlusion in its vertices, for any program that opens .glb files.
echo "demo: out/chess-ao.glb"
if ! "$BUILD/bake" model builtin:chess -o "$OUT/chess.glb" ||
   ! "$BUILD/bake" ao "$OUT/chess.glb" -o "$OUT/chess-ao.glb" --set side=16 --set ground=auto 2> "$OUT/probe.txt"; then
    if grep -q 'glTF parser' "$OUT/probe.txt"; then leave "chess-ao.glb ($(tail -n 1 "$OUT/probe.txt"))"
    else cat "$OUT/probe.txt"; failures=$((failures + 1)); fi
fi
rm -f "$OUT/probe.txt"
write_page
rm -f "$OUT"/*.pfm
echo "demo: wrote $OUT/index.html, $OUT/which.html and $OUT/contact.png"
[ $failures = 0 ]
