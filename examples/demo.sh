#!/bin/sh
# Pictures of every technique beside the reference: out/index.html. Called by `make demo`.
#   BUILD         where the programs are (build)
#   ASSETS        a folder of real models and skies; without it only built-in scenes
#   DEMO_SIZE     480x270; DEMO_SAMPLES of csm 256; DEMO_REFERENCE of the reference 512
#   DEMO_SCENES   which rows to make, e.g. "cornell knot"
set -u
BUILD=${BUILD:-build}
OUT=${OUT:-out}
SIZE=${DEMO_SIZE:-480x270}
SAMPLES=${DEMO_SAMPLES:-256}
REFERENCE=${DEMO_REFERENCE:-512}
ASSETS=${ASSETS:-}
PAGE=$OUT/index.html
left_out=
failures=0
mkdir -p "$OUT" || exit 1
"${CC:-cc}" -std=c99 -O2 examples/demo/pfm_png.c -lm -o "$BUILD/pfm_png" || exit 1

number() {      # number FILE NAME: a number from a line of JSON
    sed -n "s/.*\"$2\": \\([-+0-9.e]*\\).*/\\1/p" "$1" 2>/dev/null
}

seconds() {
    awk "BEGIN { printf \"%.2f\", ${1:-0} / 1000 }"
}

megabytes() {
    awk "BEGIN { printf \"%.2f\", ${1:-0} / 1e6 }"
}

short() {
    awk "BEGIN { printf \"%.4f\", ${1:-0} }"
}

cell() {        # cell PICTURE TEXT
    printf '<td><img src="%s" alt="%s"><br>%s</td>\n' "$1" "$2" "$2" >> "$PAGE"
}

# row TECHNIQUE NAME TITLE ARGUMENTS: one scene by a technique and, where Embree is built in, by the reference.
# $ONLY holds the technique's own further arguments, $REFERENCE_ONLY the reference's.
ONLY= REFERENCE_ONLY=
# shellcheck disable=SC2086
row() {
    technique=$1
    name=$2
    title=$3
    shift 3
    case " ${DEMO_SCENES:-$name} " in *" $name "*) ;; *) return ;; esac
    echo "demo: $title"
    own=$name-$technique
    if ! "$BUILD/render" --technique "$technique" "$@" $ONLY --size "$SIZE" --out "$OUT/$own.pfm" --json "$OUT/$own.json"; then
        failures=$((failures + 1))
        return
    fi
    ev=$(number "$OUT/$own.json" ev)
    note=
    reference=$name-reference
    if [ -n "$has_reference" ] && "$BUILD/render" --technique reference "$@" $REFERENCE_ONLY --size "$SIZE" \
       --samples "$REFERENCE" --out "$OUT/$reference.pfm" --json "$OUT/$reference.json"; then
        ev=$(number "$OUT/$reference.json" ev)      # the same exposure in a row
        "$BUILD/compare" "$OUT/$own.pfm" "$OUT/$reference.pfm" --diff "$OUT/$own-diff.png" > "$OUT/$own-compare.json" ||
            "$BUILD/compare" "$OUT/$own.pfm" "$OUT/$reference.pfm" > "$OUT/$own-compare.json"
        note="; reference in $(seconds "$(number "$OUT/$reference.json" frame_ms)") s"
        note="$note; relative RMSE $(short "$(number "$OUT/$own-compare.json" relative_rmse)")"
        note="$note (noise of the reference $(short "$(number "$OUT/$reference.json" noise)"))"
        note="$note, SSIM $(short "$(number "$OUT/$own-compare.json" ssim)")"
    fi
    "$BUILD/pfm_png" "$OUT/$own.pfm" "$OUT/$own.png" "$ev"
    printf '<h2>%s</h2>\n<table><tr>\n' "$title" >> "$PAGE"
    cell "$own.png" "$technique"
    if [ -n "$note" ]; then
        "$BUILD/pfm_png" "$OUT/$reference.pfm" "$OUT/$reference.png" "$ev"
        cell "$reference.png" "reference, $REFERENCE samples"
        [ -f "$OUT/$own-diff.png" ] && cell "$own-diff.png" "difference"
    fi
    printf '</tr></table>\n<p>%s triangles; precomputed in %s s, %s MB kept; picture in %s s%s</p>\n' \
        "$(number "$OUT/$own.json" triangles)" "$(seconds "$(number "$OUT/$own.json" precompute_ms)")" \
        "$(megabytes "$(number "$OUT/$own.json" memory_bytes)")" "$(seconds "$(number "$OUT/$own.json" frame_ms)")" \
        "$note" >> "$PAGE"
}

has_reference=yes
if "$BUILD/render" --list | grep -q '^  reference.*needs Embree'; then
    has_reference=
    left_out="the reference and what is measured against it (libembree-dev is missing)"
fi
cat > "$PAGE" <<'HTML'
<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Dapple: pictures</title>
<style>
body { font-family: sans-serif; max-width: 100em; margin: 2em auto; color: #222; }
td { text-align: center; font-size: small; padding: 0 0.5em 0 0; } img { max-width: 31em; width: 100%; }
</style></head><body>
<h1>Dapple</h1>
<p>Direct light by each technique beside a path tracer, at one exposure a row. In difference pictures grey is equal,
red too bright, blue too dark. Relative RMSE contains the noise of both pictures.</p>
HTML

ONLY="--samples $SAMPLES"
row csm cornell "Cornell box: emissive rectangle, cube maps of places on it" --scene builtin:cornell
ONLY="$ONLY --set side=64"
row csm chess "Chess: 33 objects share the maps of 13 meshes; sky" --scene builtin:chess
ONLY="--samples $SAMPLES"
row csm plant "Plant: sky" --scene builtin:plant
row csm knot "Knot: sky" --scene builtin:knot
row csm knot-sun "Knot: sun, a map of its own direction" --scene builtin:knot --light sun:0.48,0.8,0.36
has_gl= ONLY= REFERENCE_ONLY="--set bounces=1"
row rsm cornell-bounce "Cornell box: bounced light of its emissive rectangle by 16 reflective shadow maps" \
    --scene builtin:cornell
row rsm uroom-bounce "U-shaped room: bounced light of a spot" --scene builtin:uroom
if "$BUILD/render" --technique rsm --backend gl --scene builtin:uroom --size 16x16 --samples 4 --set m=16 --out "$OUT/probe.pfm" \
   2> /dev/null; then
    has_gl=1
    ONLY="--backend gl --set mode=interpolated"
    row rsm uroom-gl "U-shaped room: the same on OpenGL, interpolated" --scene builtin:uroom
    ONLY=
else
    echo "demo: left out: rows on OpenGL"
fi
rm -f "$OUT/probe.pfm"
row ism cornell-shadows "Cornell box: bounced light and its shadows by imperfect shadow maps" --scene builtin:cornell
row ism uroom-shadows "U-shaped room: 1024 virtual point lights, chosen by what the picture shows" --scene builtin:uroom
if "$BUILD/render" --technique ism --backend gl --scene builtin:uroom --size 8x8 --set vpls=1 --set points=8 --set tile=8 \
   --out "$OUT/probe.png" 2> "$OUT/probe.txt"; then
    ONLY='--backend gl --set points=2048'
    row ism cloth-gl "Cloth in the wind: bounced light and its shadows on OpenGL, 2048 points a light" --scene builtin:cloth
    ONLY=
else
    left_out="${left_out:+$left_out; }OpenGL ($(tail -1 "$OUT/probe.txt"))"
fi
rm -f "$OUT/probe.png" "$OUT/probe.txt"
ONLY="--set position_side=8 --set spacing=0.04" REFERENCE_ONLY=
row shadowfield chess-field "Chess: 33 objects share 7 shadow fields; overcast sky" --scene builtin:chess \
    --env builtin:overcast
ONLY="--set position_side=6 --set spacing=0.04"
row shadowfield robots-field "Robots with spot lights and bullets that shine" --scene builtin:robots
ONLY="--set position_side=4 --set spacing=0.04 --set basis=haar --set shells=12 --set keep=0.02"
row shadowfield ships-field "Ships over robots, all frequencies" --scene builtin:spaceships
ONLY="--set position_side=4 --set spacing=0.04"
row shadowfield explosion-field "Explosion: fire as a light that changes with time" --scene builtin:explosion
ONLY=
row envshadow knot-env "Knot: the sky as 256 lights with shadow maps" --scene builtin:knot
row envshadow cloth-env "Cloth in the wind: the sky as 256 lights" --scene builtin:cloth
row envshadow figure-env "Dressed figure: the sky as 256 lights" --scene builtin:figure
ONLY="--backend gl"
[ -n "$has_gl" ] && row envshadow plant-gl "Plant: the sky as 256 lights, on OpenGL" --scene builtin:plant
ONLY="--samples $SAMPLES"
if [ -n "$ASSETS" ]; then
    for model in bunny dragon; do
        [ -f "$ASSETS/$model.glb" ] && row csm $model "$model.glb: built-in sky" --scene "$ASSETS/$model.glb"
    done
    if [ -f "$ASSETS/bunny.glb" ] && [ -f "$ASSETS/venice_sunset_1k.hdr" ]; then
        row csm bunny-venice "bunny.glb: venice_sunset_1k.hdr" --scene "$ASSETS/bunny.glb" \
            --env "$ASSETS/venice_sunset_1k.hdr" --set m=256
    fi
else
    left_out="${left_out:+$left_out; }real models and skies (ASSETS is not set)"
fi
[ -n "$left_out" ] && printf '<p>Left out: %s.</p>\n' "$left_out" >> "$PAGE"
printf '</body></html>\n' >> "$PAGE"
rm -f "$OUT"/*.pfm
[ -n "$left_out" ] && echo "demo: left out: $left_out"
echo "demo: wrote $PAGE"
[ $failures = 0 ]
