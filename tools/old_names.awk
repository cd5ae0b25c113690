# old_names.awk - the names that CHANGELOG.md's tables give in their column "before" and that no header has any more: awk -f
# old_names.awk HEADER... CHANGELOG.md. Prints an extended regular expression a line: rsm_filter_create, ism_desc\.points, and
# for a family GLBK_CSM_ASK_[A-Za-z0-9_]*. A second name may be short, as `_reset` behind `rsm_filter_free`.
BEGIN {
    # Fields whose line tells of another meaning: the names stay.
    split("rsm_mesh.indices rsm_points.normals", list, " ")
    for (i in list) same[list[i]] = 1
    prefixes = "^(cohsm|sfield|envsh|envlt|rsm|ism|lsamp|gifilt|glbk|COHSM|SFIELD|ENVSH|ENVLT|RSM|ISM|LSAMP|GIFILT|GLBK|CSM|SHADOWFIELD|ENVSHADOW|GL_BACKEND)_"
}
# Names in the headers, those in comments not counted.
FNR == 1 { in_comment = 0 }
FILENAME !~ /CHANGELOG\.md$/ {
    if (in_comment) { if (!sub(/^.*\*\//, "")) next; in_comment = 0 }
    gsub(/\/\*([^*]|\*[^\/])*\*\//, " ")
    if (sub(/\/\*.*/, "")) in_comment = 1
    gsub(/[^A-Za-z0-9_]+/, " ")
    n = split($0, word, " ")
    for (i = 1; i <= n; i++) if (!(word[i] in here)) { here[word[i]] = 1; if (word[i] ~ prefixes) all = all "\n" word[i] }
    next
}
/^\|.*before *\|/ { on = 1; next }
!/^\|/ { on = 0; next }
on && !/^\|-/ {
    n = split($0, cell, "|")
    m = split(cell[2], quoted, "`")
    before = ""
    for (i = 2; i <= m; i += 2) {
        text = quoted[i]
        sub(/^#include.*/, "", text)
        while (match(text, /[A-Za-z_][A-Za-z0-9_.]*/)) {
            take(substr(text, RSTART, RLENGTH))
            text = substr(text, RSTART + RLENGTH)
        }
    }
}
function take(name,    part) {
    family = name ~ /_\.\.\.$/ || name ~ /_$/
    sub(/\.\.\.$/, "", name)
    if (name ~ /\.\./ || name in same) return
    if (name ~ /^_[a-zA-Z]/ && before != "") { part = before; sub(/\..*/, "", part); sub(/_[A-Za-z0-9]*_?$/, "", part); name = part name }
    else if (name !~ prefixes) return
    before = name
    sub(/\.$/, "", name)
    if (family) { if (!index(all, "\n" name)) print name "[A-Za-z0-9_]*"; return }
    if (name ~ /\./) { gsub(/\./, "\\.", name); print name; return }
    if (!(name in here)) print name
}
