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

# row NAME TITLE ARGUMENTS: one scene by csm and, where Embree is built in, by the reference
row() {
    name=$1
    title=$2
    shift 2
    case " ${DEMO_SCENES:-$name} " in *" $name "*) ;; *) return ;; esac
    echo "demo: $title"
    base=$OUT/$name
    if ! "$BUILD/render" --technique csm "$@" --size "$SIZE" --samples "$SAMPLES" --out "$base-csm.pfm" \
         --json "$base-csm.json"; then
        failures=$((failures + 1))
        return
    fi
    ev=$(number "$base-csm.json" ev)
    with_reference=0
    if [ -n "$has_reference" ] && "$BUILD/render" --technique reference "$@" --size "$SIZE" --samples "$REFERENCE" \
       --out "$base-reference.pfm" --json "$base-reference.json"; then
        with_reference=1
        ev=$(number "$base-reference.json" ev)      # the same exposure in a row
    fi
    "$BUILD/pfm_png" "$base-csm.pfm" "$base-csm.png" "$ev"
    printf '<h2>%s</h2>\n<table><tr>\n' "$title" >> "$PAGE"
    cell "$name-csm.png" "csm, $SAMPLES samples"
    error= ssim= reference_s=
    if [ $with_reference = 1 ]; then
        "$BUILD/pfm_png" "$base-reference.pfm" "$base-reference.png" "$ev"
        cell "$name-reference.png" "reference, $REFERENCE samples"
        if "$BUILD/compare" "$base-csm.pfm" "$base-reference.pfm" --diff "$base-diff.png" > "$base-compare.json" ||
           "$BUILD/compare" "$base-csm.pfm" "$base-reference.pfm" > "$base-compare.json"; then
            [ -f "$base-diff.png" ] && cell "$name-diff.png" "difference"
            error=$(short "$(number "$base-compare.json" relative_rmse)")
            ssim=$(short "$(number "$base-compare.json" ssim)")
            noise=$(short "$(number "$base-reference.json" noise)")
            reference_s=$(seconds "$(number "$base-reference.json" frame_ms)")
        fi
    fi
    {
        printf '</tr></table>\n<p>%s triangles; maps built in %s s, %s MB kept, ratio %s; picture in %s s' \
            "$(number "$base-csm.json" triangles)" "$(seconds "$(number "$base-csm.json" precompute_ms)")" \
            "$(megabytes "$(number "$base-csm.json" memory_bytes)")" "$(number "$base-csm.json" ratio)" \
            "$(seconds "$(number "$base-csm.json" frame_ms)")"
        [ -n "$error" ] && printf '; reference in %s s; relative RMSE %s (noise of the reference %s), SSIM %s' \
            "$reference_s" "$error" "$noise" "$ssim"
        printf '</p>\n'
    } >> "$PAGE"
}

# rsm_row NAME TITLE ARGUMENTS: one scene by rsm beside the reference of one bounce
rsm_row() {
    name=$1
    title=$2
    shift 2
    case " ${DEMO_SCENES:-$name} " in *" $name "*) ;; *) return ;; esac
    echo "demo: $title"
    base=$OUT/$name
    if ! "$BUILD/render" --technique rsm "$@" --size "$SIZE" --out "$base-rsm.pfm" --json "$base-rsm.json"; then
        failures=$((failures + 1))
        return
    fi
    ev=$(number "$base-rsm.json" ev)
    note=
    if [ -n "$has_reference" ] && "$BUILD/render" --technique reference "$@" --set bounces=1 --size "$SIZE" \
       --samples "$REFERENCE" --out "$base-reference.pfm" --json "$base-reference.json"; then
        ev=$(number "$base-reference.json" ev)
        "$BUILD/compare" "$base-rsm.pfm" "$base-reference.pfm" --diff "$base-diff.png" > "$base-compare.json" ||
            "$BUILD/compare" "$base-rsm.pfm" "$base-reference.pfm" > "$base-compare.json"
        note="; relative RMSE $(short "$(number "$base-compare.json" relative_rmse)")"
    fi
    "$BUILD/pfm_png" "$base-rsm.pfm" "$base-rsm.png" "$ev"
    printf '<h2>%s</h2>\n<table><tr>\n' "$title" >> "$PAGE"
    cell "$name-rsm.png" "rsm, 400 samples a map"
    if [ -n "$note" ]; then
        "$BUILD/pfm_png" "$base-reference.pfm" "$base-reference.png" "$ev"
        cell "$name-reference.png" "reference, one bounce, $REFERENCE samples"
        [ -f "$base-diff.png" ] && cell "$name-diff.png" "difference"
    fi
    printf '</tr></table>\n<p>%s maps, drawn, gathered and shaded in %s s%s</p>\n' "$(number "$base-rsm.json" maps)" \
        "$(seconds "$(number "$base-rsm.json" frame_ms)")" "$note" >> "$PAGE"
}

# field_row NAME TITLE ARGUMENTS: one scene by shadowfield beside the reference; those of shadowfield alone in $FIELD
field_row() {
    name=$1
    title=$2
    shift 2
    case " ${DEMO_SCENES:-$name} " in *" $name "*) ;; *) return ;; esac
    echo "demo: $title"
    base=$OUT/$name
    # shellcheck disable=SC2086
    if ! "$BUILD/render" --technique shadowfield "$@" $FIELD --size "$SIZE" --out "$base-field.pfm" \
         --json "$base-field.json"; then
        failures=$((failures + 1))
        return
    fi
    ev=$(number "$base-field.json" ev)
    note=
    if [ -n "$has_reference" ] && "$BUILD/render" --technique reference "$@" --size "$SIZE" --samples "$REFERENCE" \
       --out "$base-reference.pfm" --json "$base-reference.json"; then
        ev=$(number "$base-reference.json" ev)
        "$BUILD/compare" "$base-field.pfm" "$base-reference.pfm" --diff "$base-diff.png" > "$base-compare.json" ||
            "$BUILD/compare" "$base-field.pfm" "$base-reference.pfm" > "$base-compare.json"
        note="; relative RMSE $(short "$(number "$base-compare.json" relative_rmse)")"
    fi
    "$BUILD/pfm_png" "$base-field.pfm" "$base-field.png" "$ev"
    printf '<h2>%s</h2>\n<table><tr>\n' "$title" >> "$PAGE"
    cell "$name-field.png" "shadowfield, 4 bands"
    if [ -n "$note" ]; then
        "$BUILD/pfm_png" "$base-reference.pfm" "$base-reference.png" "$ev"
        cell "$name-reference.png" "reference, $REFERENCE samples"
        [ -f "$base-diff.png" ] && cell "$name-diff.png" "difference"
    fi
    printf '</tr></table>\n<p>%s fields built in %s s, %s MB kept; %s points shaded in %s s%s</p>\n' \
        "$(number "$base-field.json" fields)" "$(seconds "$(number "$base-field.json" precompute_ms)")" \
        "$(megabytes "$(number "$base-field.json" memory_bytes)")" "$(number "$base-field.json" points)" \
        "$(seconds "$(number "$base-field.json" frame_ms)")" "$note" >> "$PAGE"
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

row cornell "Cornell box: emissive rectangle, cube maps of places on it" --scene builtin:cornell
row chess "Chess: 33 objects share the maps of 13 meshes; sky" --scene builtin:chess --set side=64
row plant "Plant: sky" --scene builtin:plant
row knot "Knot: sky" --scene builtin:knot
row knot-sun "Knot: sun, a map of its own direction" --scene builtin:knot --light sun:0.48,0.8,0.36
rsm_row cornell-bounce "Cornell box: bounced light of its emissive rectangle by 16 reflective shadow maps" \
    --scene builtin:cornell
rsm_row uroom-bounce "U-shaped room: bounced light of a spot" --scene builtin:uroom
FIELD="--set position_side=8 --set spacing=0.04"
field_row chess-field "Chess: 33 objects share 7 shadow fields; overcast sky" --scene builtin:chess \
    --env builtin:overcast
if [ -n "$ASSETS" ]; then
    for model in bunny dragon; do
        [ -f "$ASSETS/$model.glb" ] && row $model "$model.glb: built-in sky" --scene "$ASSETS/$model.glb"
    done
    if [ -f "$ASSETS/bunny.glb" ] && [ -f "$ASSETS/venice_sunset_1k.hdr" ]; then
        row bunny-venice "bunny.glb: venice_sunset_1k.hdr" --scene "$ASSETS/bunny.glb" \
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
