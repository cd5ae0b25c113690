#!/bin/sh
# links.sh PAGE... - every link of the pages leads to a file that is there, and behind # to a heading that is there (as
# GitHub makes anchors of headings). Links to other hosts are not followed.
status=0
for page; do
    awk -v page="$page" '
        function anchor(text) {
            text = tolower(text)
            gsub(/[`*]/, "", text)
            while (match(text, /\]\([^)]*\)/)) text = substr(text, 1, RSTART - 1) substr(text, RSTART + RLENGTH)
            gsub(/[^a-z0-9_ -]/, "", text)
            gsub(/ /, "-", text)
            return text
        }
        function read(file,    line, fenced, n, text) {
            if (file in known) return
            known[file] = 1
            while ((getline line < file) > 0) {
                if (line ~ /^```/) fenced = !fenced
                if (fenced || line !~ /^#+ /) continue
                sub(/^#+ /, "", line)
                text = anchor(line)
                for (n = 0; (file "#" text (n ? "-" n : "")) in there; n++) {}
                there[file "#" text (n ? "-" n : "")] = 1
            }
            close(file)
        }
        function plain(path) {
            while (match(path, /[^\/.]+\/\.\.\//)) path = substr(path, 1, RSTART - 1) substr(path, RSTART + RLENGTH)
            gsub(/\/\.\//, "/", path)
            return path
        }
        BEGIN { folder = page; if (!sub(/[^\/]*$/, "", folder)) folder = "" }
        /^```/ { inside = !inside }
        inside { next }
        {
            text = $0
            while (match(text, /\]\([^) ]+\)/)) {
                link = substr(text, RSTART + 2, RLENGTH - 3)
                text = substr(text, RSTART + RLENGTH)
                if (link ~ /^[a-z]+:/) continue
                file = name = link
                sub(/#.*/, "", file)
                if (!sub(/^[^#]*#/, "", name)) name = ""
                file = file == "" ? page : plain(folder file)
                if (system("test -e \"" file "\"")) { print "links: " page ":" NR ": " link ": no such file"; failed = 1; continue }
                if (name == "" || file !~ /\.md$/) continue
                read(file)
                if (!((file "#" name) in there)) { print "links: " page ":" NR ": " link ": no such heading"; failed = 1 }
            }
        }
        END { exit failed }' "$page" || status=1
done
[ $status = 0 ] && echo "links: of $# pages lead to what is there"
exit $status
