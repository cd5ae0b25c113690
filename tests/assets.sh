#!/bin/sh
# assets.sh - the converter behind make assets: polygons as fans, arrays of npm's modules, and what must be refused.
# Needs no network. Last line: "assets: N passed, N failed, 0 skipped".
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
passed=0 failed=0
${CC:-cc} -std=c99 -O1 tools/assets/glb.c -lm -o "$dir/glb" || exit 1

indices() {     # indices COUNT: the last ones of the file
    tail -c $((4 * $1)) "$dir/out.glb" | od -An -v -tu4 -w$((4 * $1)) | tr -s ' '
}
is() {          # is NAME WANTED GOT
    if [ "$2" = "$3" ]; then passed=$((passed + 1)); else
        echo "  FAILED: $1: wanted '$2', got '$3'"
        failed=$((failed + 1))
    fi
}
ply() {         # ply FACES: of a pentagon's corners and one more, with a colour to skip
    printf 'ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\nproperty uchar c\n'
    printf 'element face %s\nproperty list uchar int vertex_indices\nend_header\n' "$(echo "$1" | wc -l)"
    printf '0 0 0 9\n1 0 0 9\n1 1 0 9\n.5 2 0 9\n0 1 -1e-3 9\n5 5 5 9\n%s\n' "$1"
}
ply '5 0 1 2 3 4
4 5 4 3 2
3 0 1 5' | "$dir/glb" > "$dir/out.glb"
is 'fans' ' 0 1 2 0 2 3 0 3 4 5 4 3 5 3 2 0 1 5' "$(indices 18)"
is 'size' "$(od -An -tu4 -j8 -N4 "$dir/out.glb" | tr -d ' ')" "$(wc -c < "$dir/out.glb" | tr -d ' ')"
echo 'exports.positions=[[0,0,0],[1,0,0],[0,-1.5e-1,0]];exports.cells=[[2,1,0]]' | "$dir/glb" > "$dir/out.glb"
is 'arrays' ' 2 1 0' "$(indices 3)"
for bad in '3 0 1 6' '2 0 1' '70 1' '3 0 1 -1'; do
    ply "$bad" | "$dir/glb" > /dev/null 2> "$dir/error"
    is "refused: $bad" '1 1' "$? $(wc -l < "$dir/error" | tr -d ' ')"
done
for bad in '' 'positions=[[0,0,1' 'positions=[[0,0]];cells=[[0,0,0]]' 'positions=[[0,0,0]];cells=[]' 'ply' 'ply
format ascii 1.0
element vertex 9' 'ply
format binary_little_endian 1.0
end_header'; do
    printf '%s' "$bad" | "$dir/glb" > /dev/null 2> "$dir/error"
    is "refused: $bad" '1 1' "$? $(wc -l < "$dir/error" | tr -d ' ')"
done
echo "assets: $passed passed, $failed failed, 0 skipped"
[ -n "$TOTALS" ] && echo "$passed $failed 0" >> "$TOTALS"
[ $failed = 0 ]
