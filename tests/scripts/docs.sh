#!/bin/sh
# check HEADER... - cuts the code out of the documents and builds it as it stands, with the repository's root on the
# include path: every block fenced by ```c in README.md, CONTRIBUTING.md and docs/, and the Quick start in the comment
# at the top of each header, that is, the lines indented by four or more after a line that has "Quick start". A block
# with main() is linked, any other one compiled; a Quick start is run and must end with status 0. Inside it write //
# for comments: it stands in a comment itself. docs/programs.md is compared with what the programs say of themselves. Links of all
# pages are followed.
CC=${CC:-gcc}
dir=${BUILD:-build}/docs-check
rm -rf "$dir" && mkdir -p "$dir" || exit 1
flags='-std=c99 -pedantic -Wall -Wextra -Werror -O1 -I.'
failed=0

for file in README.md CONTRIBUTING.md docs/*.md; do
    [ -f "$file" ] || continue
    awk -v out="$dir/$(echo "$file" | tr / -)" '
        /^```c$/ && !inside {
            inside = 1
            name = out "." ++n ".c"
            printf "#line %d \"%s\"\n", NR + 1, FILENAME > name
            next
        }
        /^```/              { if (inside) close(name); inside = 0; next }
        inside              { print > name }' "$file"
done
for file in "$@"; do
    name=$(echo "$file" | tr / -)
    sh tools/quick-start "$file" > "$dir/$name.quick.c" || { echo "check-docs: $file has no Quick start"; failed=1; }
    # As C++ too, where { 0 } leaves fields without a value and -Wextra says so.
    if command -v "${CXX:-g++}" > /dev/null; then
        "${CXX:-g++}" -std=c++11 -pedantic -Wall -Wextra -Werror -I. -fsyntax-only -x c++ "$dir/$name.quick.c" ||
            { echo "check-docs: FAILED as C++: $file"; failed=1; }
    fi
done

for name in $(sed -n 's/^    { "\([a-z0-9_]*\)", .*bn_.*/\1/p' bench/main.c); do
    grep -q "^| .$name. |" docs/programs.md || { echo "check-docs: docs/programs.md has no row for bench $name"; failed=1; }
done

# Every key of --set with its values and default, as `render --list` has them; every field of render's JSON.
if [ -x "${BUILD:-build}/render" ]; then
    "${BUILD:-build}/render" --list > "$dir/list"
    awk -v page=docs/programs.md '
        BEGIN {
            while ((getline line < page) > 0)
                if (line ~ /^Settings of .*:$/) section = substr(line, 13, length(line) - 13)
                else if (line ~ /^#/) section = ""
                else rows[section] = rows[section] line "\n"
        }
        /^settings of/ { name = $0; sub(/^settings of /, "", name); sub(/ \(.*/, "", name); next }
        name && NF {
            text = range = ""
            count = split($2, part, "|")
            for (i = 1; i <= count; i++)
                if (part[i] ~ /\.\./) range = part[i]
                else text = text (text == "" ? "" : ", ") part[i]
            if (sub(/\.\./, " to ", range)) text = text (text == "" ? "" : " or ") range
            row = "| `" $1 "` | " text " | " substr($3, 2, length($3) - 2) " |"
            if (!index(rows[name], row)) { print "check-docs: " page ", settings of " name ": no row " row; failed = 1 }
        }
        END { exit failed }' "$dir/list" || failed=1
else
    echo "check-docs: ${BUILD:-build}/render is not built: its keys are not compared with docs/programs.md"
fi
for name in $(sed -n 's/.*rd_json_[a-z]*([^"]*"\([a-z_0-9]*\)".*/\1/p' examples/render/*.c | sort -u); do
    grep -q "\`$name\`" docs/programs.md || { echo "check-docs: docs/programs.md has no field $name of render"; failed=1; }
done

sh tests/scripts/links.sh *.md docs/*.md docs/measured/*.md examples/*.md src/*.md tests/*.md || failed=1

# docs/gpu-layouts.md: every uniform block that a header of gl_backend/ declares.
for name in $(grep -hoE 'X\(glbk_[a-z_]+, [0-9]+, GLBK_[A-Z_]+MEMBERS' src/gl*/bindings.h | sed 's/X(//; s/,.*//' | sort -u); do
    grep -q "$name" docs/gpu-layouts.md || { echo "check-docs: docs/gpu-layouts.md has no block $name"; failed=1; }
done

# And every member of a block that has a row there, but padding; a row may say "the material", which has one of its own.
awk '
function all(macro,   n, part, i, list) {
    n = split(members[macro], part, " ")
    for (i = 1; i <= n; i++) list = list " " (part[i] ~ /^@/ ? all(substr(part[i], 2)) : part[i])
    return list
}
/^#define GLBK_[A-Z_]*MEMBERS\(X\)/ { name = $2; sub(/\(X\).*/, "", name); inside = 1 }
inside {
    if ($1 ~ /^GLBK_[A-Z_]*MEMBERS\(X\)/) { part = $1; sub(/\(X\).*/, "", part); members[name] = members[name] " @" part }
    for (line = $0; match(line, /X\([a-z0-9]+, [a-z0-9_]+, [0-9]+\)/); line = substr(line, RSTART + RLENGTH)) {
        split(substr(line, RSTART, RLENGTH), field, ", ")
        members[name] = members[name] " " field[2]
    }
    inside = /\\$/
}
match($0, /X\(glbk_[a-z_]+, [0-9]+, GLBK_[A-Z_]+MEMBERS/) {
    split(substr($0, RSTART + 2, RLENGTH - 2), field, ", ")
    block[field[1]] = field[3]
}
END { for (b in block) print b all(block[b]) }' src/gl*/bindings.h > "$dir/blocks"
while read -r block names; do
    row=$(grep "^| $block[ ,]" docs/gpu-layouts.md)
    case $row in '') continue ;; *'the material'*) row="$row $(grep '^| the material ' docs/gpu-layouts.md)" ;; esac
    for name in $names; do
        case $name in pad[0-9] | unused[0-9]) continue ;; esac
        echo "$row" | grep -qw "$name" || { echo "check-docs: docs/gpu-layouts.md: $block has no $name"; failed=1; }
    done
done < "$dir/blocks"

# docs/adapter.md: the rows linked with a renderer of one's own, for which rays stand.
# shellcheck disable=SC2086
$CC $flags -DADAPTER_ALONE -Itests/kit -Itests/kit/shim tests/adapter/rows.c tests/adapter/rays_rows_test.c -lm -o "$dir/rows" ||
    { echo "check-docs: FAILED: the line of docs/adapter.md"; failed=1; }

count=0
for file in "$dir"/*.c; do
    [ -f "$file" ] || continue
    count=$((count + 1))
    if grep -q 'main(' "$file"; then last="-lm -o $dir/program"; else last="-c -o $dir/object.o"; fi
    # shellcheck disable=SC2086
    $CC $flags "$file" $last || { echo "check-docs: FAILED: $file"; failed=1; continue; }
    case $file in
    *.quick.c) "$dir/program" || { echo "check-docs: FAILED: $file ends with status $?"; failed=1; } ;;
    esac
done
echo "check-docs: $count snippets built"
exit $failed
