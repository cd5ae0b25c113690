# vocabulary.awk - the rules of src/README.md, "Vocabulary", on the public part of one header. tools/check-vocabulary calls
# it: awk -v header= -v prefix= -v file= -f vocabulary.awk src/README.md HEADER. Prints one line for each breach.
#
# A new public function, type or field needs no change here unless it brings a new word. If the word is right, it goes
# into the list that refused it, and the table of src/README.md says it.
BEGIN {
    upper = toupper(prefix)
    gl = prefix == "glbk"
    technique = gl && file != "GL_BACKEND"

    # The last word of a public function: what it does, or what it returns.
    verbs = "abandon accumulate add apply ask begin bind bounce build cast check choose clear compile compress create denoise " \
        "dispatch draw end eval exp fill find finish fit follow forget forward free gather hit illuminate import init interpolate " \
        "inverse jitter log match merge move open pack place prepare project query rasterize read redraw render replay reset " \
        "resize resolve restart restore rotate run sample save scatter see shade spread turn unzoom update upload use verify " \
        "write zoom"
    nouns = "ambient angle as atlas basis block brdf budget bytes callback cluster coordinates cosine count data depth depths direct " \
        "direction directions domain dot emissive emitter entities environment file fill glsl image importances incident " \
        "indices info irradiance lights list location locations matrix mean n noise object of part points product residual " \
        "rotation scene screen self set sh sky slots source sources sparse stats storage strata sun surfels terms texel texels text " \
        "texture triangles twin view views visible vpls window"
    split_into(verbs " " nouns, words)
    # What a name must not be or end with, and the word of the table for it.
    set_pairs("size=bytes,_side_or_count len=count length_bytes=bytes num=count nb=count cnt=count resolution=side res=side " \
        "pitch=stride step_bytes=stride deg=radians degrees=radians deg2=radians camera=view eye_view=view " \
        "occluder=caster occluders=casters type=kind sort=kind luminaire=light lamp=light lamps=lights " \
        "image_width=width blocker=caster axis_angle=cone_half_angle half_cone=cone_half_angle view_projection=world_to_clip " \
        "view_proj=world_to_clip mvp=world_to_clip view_matrix=world_to_view geometric=geometric_normals " \
        "geometric_stride=geometric_normal_stride lookfrom=to_eye ao=open ambient_occlusion=open openness=open allocator_user=user", instead)
    # Words that stand nowhere in a name: of a type, a value, a function, a field, a parameter, a macro.
    set_pairs("camera=view cameras=views luminaire=light luminaires=lights blocker=caster blockers=casters resolution=_side " \
        "pitch=_stride degrees=radians destroy=free delete=free release=free len=_bytes_or_count cnt=_count nb=_count num=_count " \
        "dir=direction dirs=directions wo=to_eye wi=direction idx=index interleaving=interleave interleaved=interleave proj=projection", nowhere)
    # What a name must not be as a whole: world_to_clip ends with one of these words.
    set_pairs("clip=world_to_clip", instead_whole)
    set_pairs("num_=count nb_=count n_=count max_num_=count", instead_front)
    # Fields and parameters of these types have one name each, or end with it. glbk_csm_use.ask is how maps are asked, and
    # no kind of the struct.
    set_pairs("rows=rows clip_depth=clip_depth clip_y=clip_y light_kind=kind", named_after)
    # The matrices, by the way that they go. cohsm_view's and sfield_sh_rotation's go to pixels and nowhere.
    split_into("transform transforms world_to_clip to_world matrix before", matrices)
    # Counts without _count: orders and their like, times in frames, and bits, which are no elements.
    split_into("bands layers levels bytes passes units dimensions lazy_frames depth_bits flags phases remembers", bare)
    # Structs of arrays that are neither meshes nor receivers: pictures of a renderer, texels of a source.
    split_into(prefix "_buffers " prefix "_source " prefix "_import", arrays)
    # Objects that are asked by x_get_info.
    asked["cohsm"] = asked["sfield"] = asked["envsh"] = asked["rsm"] = asked["ism"] = 1
}
function split_into(text, set,    n, part, i) { n = split(text, part, " "); for (i = 1; i <= n; i++) set[part[i]] = 1 }
function set_pairs(text, map,    n, part, i, pair) {
    n = split(text, part, " ")
    for (i = 1; i <= n; i++) { split(part[i], pair, "="); map[pair[1]] = pair[2] }
}
function complain(text) { if (!(text in said)) { said[text] = 1; print "check-vocabulary: " header ": " text; bad = 1 } }
function squeeze(text) { gsub(/[ \t]+/, " ", text); sub(/^ /, "", text); sub(/ $/, "", text); return text }

# Code without comments, which may go on over lines.
function code(line,    at, end, out) {
    out = ""
    while (line != "") {
        if (in_comment) {
            end = index(line, "*/")
            if (!end) { comment = comment " " line; return out }
            out = out " " private_mark(comment " " substr(line, 1, end - 1))
            line = substr(line, end + 2)
            in_comment = 0
        } else {
            at = index(line, "/*")
            if (!at) return out line
            out = out substr(line, 1, at - 1)
            line = substr(line, at + 2)
            in_comment = 1
            comment = out == "" ? "" : "beside"
            in_braces = depth > 0 || index(out, "{")
        }
    }
    return out
}

# Members of a struct that its comments call private: "@rest" (those behind), "@all" (and the one before), "@one" (that
# one), each with what else the comment names; "@struct".
function private_mark(text,    names, beside) {
    if (!in_braces || text !~ /[Pp]rivate/) return ""
    beside = text ~ /^beside/
    if (text ~ /all that follows/) return "@all,"
    if (text ~ /[Tt]he rest is private/) return "@rest,"
    if (text ~ /^beside *private *$/ && !depth) return "@struct,"
    if (!depth) return ""
    names = ""
    if (text ~ /private, like /) { names = text; sub(/.*private, like /, "", names); sub(/[:;.].*/, "", names); gsub(/,| and /, " ", names) }
    gsub(/ +/, "+", names)
    return "@one" names ","
}

# ---- what src/README.md wants ----

FNR == NR {
    if ($0 ~ /^## Vocabulary/) in_section = 1
    else if ($0 ~ /^## /) in_section = 0
    else if (in_section && $0 ~ /^```/) { in_block = !in_block; next }
    if (in_section && in_block && $0 !~ /^ *\.\.\./) take(own_prefix(code($0)), "wanted")
    next
}
function own_prefix(text,    out, at, before) {
    out = ""
    while ((at = match(text, /(^|[^A-Za-z0-9_])[xX]_/)) > 0) {
        before = substr(text, 1, RSTART + RLENGTH - 3)
        out = out before (substr(text, RSTART + RLENGTH - 2, 1) == "x" ? prefix : upper) "_"
        text = substr(text, RSTART + RLENGTH)
    }
    return out text
}

# ---- what the header has ----

FNR == 1 { in_comment = 0; open_macro = 0; statement = ""; depth = 0 }
in_implementation { if ($0 ~ /immintrin/) vectors = 1; if (index($0, upper "_NO_SIMD")) no_simd = 1; next }
/^#(el)?if.*defined\([A-Z_]*_IMPLEMENTATION\) && / && index($0, "defined(" file "_IMPLEMENTATION)") && !/#error/ && !/STATIC/ {
    in_implementation = 1; next
}
{ take(code($0), "have") }

# Gathers macros and statements of either text, and hands each to its rule.
function take(line, from,    i, c, rest) {
    line = squeeze(line)
    if (open_macro || (line ~ /^#/)) {
        macro = open_macro ? macro " " line : line
        open_macro = line ~ /\\$/
        if (open_macro) sub(/\\$/, "", macro)
        else { take_macro(squeeze(macro), from); macro = "" }
        return
    }
    if (line == "" || line == "extern \"C\" {" || (line == "}" && depth == 0)) return
    if (depth == 0 && line ~ /^[A-Z_0-9]+__[A-Z_0-9]+\([A-Z_0-9]*\)$/) return       # GLBK__PART(CSM) declares a technique
    rest = line
    for (i = 1; i <= length(rest); i++) {
        c = substr(rest, i, 1)
        statement = statement c
        if (c == "{") depth++
        if (c == "}") depth--
        if (c == ";" && depth == 0) { take_statement(squeeze(statement), from); statement = "" }
    }
    if (statement != "") statement = statement " "
}
function take_macro(text, from) {
    macros[from] = macros[from] "\n" text
    if (index(text, "#define " upper "_RESULTS(X)") == 1) results[from] = squeeze(substr(text, length("#define " upper "_RESULTS(X)") + 1))
}
function take_statement(text, from,    name, body, head) {
    head = text
    sub(/[{].*/, "", head)
    if (text ~ /^typedef enum [a-z_0-9]+ [{]/ || text ~ /^typedef struct [a-z_0-9]+ [{]/ || text ~ /^struct [a-z_0-9]+ [{]/) {
        name = head
        sub(/^typedef /, "", name); sub(/^(enum|struct) /, "", name); sub(/ *$/, "", name)
        body = text
        sub(/^[^{]*[{] ?/, "", body); sub(/ ?[}][^}]*$/, "", body)
        if (text ~ /^typedef enum/) { if (from == "have") check_enum(name, body); return }
        structs[from, name] = body
        if (from == "have") types[name] = 1
        if (from == "have") check_struct(name, body)
        return
    }
    if (from == "wanted") return
    if (text ~ /^typedef struct [a-z_0-9]+ [a-z_0-9]+;$/) { name = text; sub(/;$/, "", name); sub(/.* /, "", name); types[name] = 1; return }
    if (text ~ /^typedef .*\(\*[a-z_0-9]+\)/) { check_callback_type(text); return }
    if (text ~ /^(struct|enum|typedef) / && text !~ /\(/) return
    if (text ~ /\(/) check_function(text)
}

# ---- functions ----

function check_function(text,    name, start, params, n, param, i, at, last, word) {
    at = index(text, "(")
    name = substr(text, 1, at - 1)
    start = text
    sub(/ .*/, "", start)
    sub(/.*[ *]/, "", name)
    if (name ~ ("^" prefix "__")) return
    if (start != upper "_DEF") { complain(name " is not declared with " upper "_DEF"); return }
    functions[name] = text
    check_words(name)
    order[++function_count] = name
    word = name
    sub(/.*_/, "", word)
    if (!(word in words)) complain(name ": its last word is none of tools/vocabulary.awk: _" word)
    params = substr(text, at + 1)
    sub(/\);$/, "", params)
    n = split_params(params, param)
    for (i = 1; i <= n; i++) {
        last = last_name(param[i])
        check_name(name, last, param[i])
        if (param[i] ~ ("^const " prefix "_system \\*") && last != "system") complain(name ": the parameter " last " is called system elsewhere")
        if (param[i] ~ /^(const )?[a-z_0-9]+_fn / && last !~ /_fn$/) complain(name ": the callback " last " has no _fn")
    }
    if (name ~ /_get_info$/ && text !~ ("^" upper "_DEF void ")) complain(name " returns nothing elsewhere")
}
# At commas that stand in no brackets.
function split_params(text, out,    i, c, level, n) {
    n = 1; out[1] = ""; level = 0
    for (i = 1; i <= length(text); i++) {
        c = substr(text, i, 1)
        if (c == "(") level++
        if (c == ")") level--
        if (c == "," && level == 0) { n++; out[n] = "" } else out[n] = out[n] c
    }
    for (i = 1; i <= n; i++) out[i] = squeeze(out[i])
    return n
}
function last_name(text) {
    if (text ~ /\(\*/) { sub(/^[^(]*\(\*/, "", text); sub(/\).*/, "", text); return text }
    gsub(/\[[^]]*\]/, "", text)
    sub(/ *$/, "", text)
    sub(/.*[ *]/, "", text)
    return text
}
function check_callback_type(text,    name) {
    name = text
    sub(/^[^(]*\(\*/, "", name); sub(/\).*/, "", name)
    check_words(name)
    if (name !~ /_fn$/ && name != prefix "_task") complain("the callback type " name " has no _fn")
}

# ---- names of fields and parameters ----

function check_words(name,    part, n, i) {
    n = split(tolower(name), part, "_")
    for (i = 1; i <= n; i++) if (part[i] in nowhere) complain(name ": the table has another word for " part[i] ", " nowhere[part[i]])
}

function check_name(where, name, whole,    word, n, type) {
    check_words(name)
    type = whole
    sub(/ .*/, "", type)
    sub("^(" prefix "|[a-z]+)_", "", type)
    if (type in named_after && name !~ ("(^|_)" named_after[type] "$") && name != "ask") complain(where ": " name ": a field of this type is called " named_after[type])
    if (name ~ /^views?(_directions?)?$/ && whole ~ /^const float \*/) complain(where ": " name ": what goes to the eye is called to_eye")
    if (name == "pattern" && whole ~ /^(u?int|size_t|unsigned)/) complain(where ": pattern: k x k pixels that share samples are called interleave")
    for (word in instead)
        if (name == word || (length(name) > length(word) && substr(name, length(name) - length(word)) == "_" word)) {
            if (name ~ /^gl_/) continue
            complain(where ": " name ": the table has another word, " instead[word])
        }
    if (name ~ /(^|_)occlusion$/ && whole ~ /^const float \*/) complain(where ": " name ": a share of light that arrives is called open")
    if (name == "visible" && whole !~ /float \*/) complain(where ": visible: an answer is floats; what the camera sees is in_view")
    if (name == "visibility" && prefix != "sfield") complain(where ": visibility: the answers for samples are called visible")
    if (name == "side" && whole ~ /^(const )?float /) complain(where ": " name ": a length in the world is no side but an edge")
    if (name in instead_whole) complain(where ": " name ": the table has another word, " instead_whole[name])
    for (word in instead_front) if (index(name, word) == 1) complain(where ": " name ": the table has _" instead_front[word])
    if (name ~ /cone/ && name != "cone_half_angle") complain(where ": " name ": a cone is given by its cone_half_angle")
    if (name ~ /_angle$/ && name !~ /^(cone_half|solid)_angle$/) complain(where ": " name ": angles have their word in the table")
    if (whole ~ /float [a-z_0-9]+\[16\]/ && !(name in matrices)) complain(where ": the matrix " name " is not called after the way that it goes")
    if (name == "rows" && whole !~ /^([a-z]+_rows|glbk_texture) /) complain(where ": rows is no " prefix "_rows")
    if (name == "clip_depth" && whole !~ /^[a-z]+_clip_depth /) complain(where ": clip_depth is no " prefix "_clip_depth")
    if (name == "clip_y" && whole !~ ("^" prefix "_clip_y ")) complain(where ": clip_y is no " prefix "_clip_y")
}
function check_struct(name, body,    n, member, i, j, parts, field, has_user, has_fn, first, second, whole, short) {
    n = split_members(name, body, member)
    check_words(name)
    short = substr(name, length(prefix) + 2)
    first = last_name(member[1]); second = n > 1 ? last_name(member[2]) : ""
    if (!technique && short ~ /(^|_)desc$/ && (!gl || short == "desc") && member[1] != prefix "_system system")
        complain("the first member of " name " is not " prefix "_system system")
    if (member[1] == "const float *positions" && short != "mesh" && !(name in arrays)) complain(name " begins like a mesh and is not called " prefix "_mesh")
    if (first == "count" && second == "positions" && short != "points" && short != "query")
        complain(name " begins like receivers and is not called " prefix "_points")
    for (i = 1; i <= n; i++) {
        whole = member[i]
        parts = split(whole, field, ",")
        for (j = 1; j <= (whole ~ /\(/ ? 1 : parts); j++) {
            if (whole ~ /\(/) field[1] = whole
            check_member(name, short, last_name(field[j]), j == 1 ? squeeze(field[1]) : whole)
        }
        if (whole ~ /\(\*/ || whole ~ /_fn [a-z]/) has_fn = last_name(whole)
        if (last_name(whole) == "user" || last_name(whole) ~ /_user$/) has_user = 1
        if (last_name(whole) == "positions" && whole ~ /^const float \*/ && i > 2 && !(name in arrays)) complain(name ": positions stand first in a mesh, and after count in receivers")
    }
    if (n > 2 && last_name(member[1]) !~ /^positions|^count/ && body ~ /const float \*positions/ && !(name in arrays)) complain(name " has positions and begins neither like a mesh nor like receivers")
    if (has_fn != "" && !has_user && !private[name, has_fn]) complain(name ": the callback " has_fn " has no user")
}
# Notes which members are private, too.
function split_members(name, body, out,    n, i, j, mark, rest, like, parts) {
    n = split(body, out, ";")
    rest = 0
    for (i = 1; i <= n; i++) {
        out[i] = squeeze(out[i])
        while (out[i] ~ /^@/) {
            mark = out[i]
            sub(/,.*/, "", mark)
            out[i] = squeeze(substr(out[i], length(mark) + 2))
            if (mark ~ /^@(all|rest|struct)/) rest = 1
            if (mark ~ /^@(all|one)/ && i > 1) private[name, last_name(out[i - 1])] = 1
            parts = split(substr(mark, 5), like, "+")
            for (j = 1; j <= parts; j++) if (mark ~ /^@one/) private[name, like[j]] = 1
        }
        if (rest) private[name, last_name(out[i])] = 1
    }
    while (n > 0 && out[n] == "") n--
    return n
}
function check_member(where, short, name, whole) {
    check_name(where, name, whole)
    if (whole ~ /\(\*/) {
        if (name !~ /_fn$/ && short != "system") complain(where ": the callback " name " has no _fn")
    } else if (whole ~ /^[a-z_0-9]+_fn / && name !~ /_fn$/) complain(where ": the callback " name " has no _fn")
    if (whole ~ /^(size_t|uint32_t|uint64_t) [a-z]/ && whole !~ /\[/ && name ~ /[^s]s$/ && short !~ /(stats|report|state|context)$/ &&
        name !~ /(^|_)bytes$/ && !(name in bare) && !private[where, name])
        complain(where ": " name " is a number of elements: _count")
}

# ---- enums ----

function check_enum(name, body,    n, value, i, base, begin) {
    check_words(name)
    if (name == prefix "_result") return
    if (name ~ /_(type|sort)$/) complain("the enum " name " tells kinds apart: _kind")
    if (body ~ /BOTTOM_FIRST/ && name != prefix "_rows") complain("the enum " name " is " prefix "_rows elsewhere")
    if (body ~ /ZERO_TO_ONE/ && name != prefix "_clip_depth") complain("the enum " name " is " prefix "_clip_depth elsewhere")
    if (body ~ /Y_DOWN|CLIP_Y/ && name != prefix "_clip_y") complain("the enum " name " is " prefix "_clip_y elsewhere")
    gsub(/=[^,]*/, "", body); gsub(/ /, "", body); sub(/,$/, "", body)
    n = split(body, value, ",")
    base = toupper(name)
    sub(/_(KIND|MODE)$/, "", base)
    begin = base
    if (value[1] ~ /_GLSL_/) begin = "GLBK_GLSL"
    if (base == upper) begin = upper "_KIND"
    for (i = 1; i <= n; i++) check_words(value[i])
    for (i = 1; i <= n; i++) if (index(value[i], begin "_") != 1) complain("the enum " name " has the value " value[i] ", which does not begin with " begin "_")
    if (value[1] !~ /_(DEFAULT|OFF|NONE)$/) complain(name " begins with " value[1] ", not with a _DEFAULT, _OFF or _NONE")
    if (value[n] != begin "_COUNT") complain(name " ends with " value[n] ", not with " begin "_COUNT")
    if (name == prefix "_rows" && n != 4 || name == prefix "_clip_depth" && n != 5 || name == prefix "_clip_y" && n != 4)
        complain(name " has not the values of the table")
}

# ---- the whole ----

function same_start(name,    wanted, have) {
    if (!(("have", name) in structs)) return
    wanted = structs["wanted", name]; have = structs["have", name]
    if (substr(have, 1, length(wanted)) != wanted) complain(name " does not begin with the members of src/README.md")
}
function object_of(name, ending) { return substr(name, 1, length(name) - length(ending)) }
END {
    if (!(("wanted", prefix "_system") in structs)) { complain("src/README.md has no section Vocabulary with its structs"); exit 1 }
    if (!technique) {
        if (substr(results["have"], 1, length(results["wanted"])) != results["wanted"]) complain(upper "_RESULTS does not begin with the twelve and their texts")
        if (gl) { sub(/ void \(\*parallel_for\)[^;]*; ?/, " ", structs["wanted", prefix "_system"]); sub(/int \(\*progress\)[^;]*; ?/, "", structs["wanted", prefix "_system"]) }
        for (i = 1; i <= 2; i++) {
            name = prefix (i == 1 ? "_allocator" : "_system")
            if (structs["have", name] != structs["wanted", name]) complain(name " is not the one of src/README.md")
        }
        if (macros["have"] !~ ("\n#ifdef " upper "_STATIC") && macros["have"] !~ ("defined\\(" upper "_STATIC\\)")) complain("has no " upper "_STATIC")
        if (macros["have"] !~ ("\n#ifndef " upper "_DEF\n")) complain("has no " upper "_DEF")
        if (vectors && !no_simd) complain("has intrinsics and no " upper "_NO_SIMD")
        if (prefix in asked && !((prefix "_get_info") in functions)) complain("has no " prefix "_get_info")
        if (!((prefix "_result_text") in functions)) complain("has no " prefix "_result_text")
    }
    for (i = 1; i <= function_count; i++) {
        name = order[i]
        if (name !~ /_get_/) continue
        sub(/_get_/, "_", name)
        if (!(name in types)) complain(order[i] ": there is no type " name ", which alone would need get_")
    }
    same_start(prefix "_mesh"); same_start(prefix "_points")
    for (i = 1; i <= function_count; i++) {
        name = order[i]
        if (name ~ /_create$/) {
            object = object_of(name, "_create")
            if (!((object "_free") in functions) && name != "glbk_indices_create") complain(name " has no " object "_free")
        }
        if (name ~ /_free$/) {
            object = object_of(name, "_free")
            if (!((object "_create") in functions) && !((object "_init") in functions) && !((object "_open") in functions) && name != "glbk_program_free")
                complain(name ": nothing is made by " object "_create, _init or _open")
        }
        if (name ~ /_init$/ && !gl && !((object_of(name, "_init") "_bytes") in functions)) complain(name " has no " object_of(name, "_init") "_bytes")
        if (name ~ /_write$/ && !gl && name != prefix "_write" && !((object_of(name, "_write") "_bytes") in functions)) complain(name " has no " object_of(name, "_write") "_bytes")
    }
    exit bad
}
