#!/bin/sh
# vocabulary.sh - breaches of src/README.md's vocabulary that tools/check-vocabulary must notice: each is put into a copy of a
# header by sed, and one line that the tool prints must have the text behind the last bar. A line: header | sed | text.
root=$PWD dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
passed=0 failed=0

mkdir -p "$dir/gl_backend" "$dir/tests" "$dir/docs"
cp -r "$root/tools" "$dir/tools"
(cd "$root" && tar cf - src/README.md src/*/parts.txt) | (cd "$dir" && tar xf -)
cd "$dir" || exit 1

fail() { printf '  FAILED: %s\n' "$1"; failed=$((failed + 1)); }
last=
noticed() {     # noticed HEADER SED TEXT: few processes, since there are many breaches
    if [ "$1" != "$last" ]; then
        last=$1 prefix=$(sh tools/prefix "$1") file=$(basename "$1" .h | tr a-z A-Z)
    fi
    sed "$2" "$root/$1" > mutant
    if cmp -s "$root/$1" mutant; then fail "$1: nothing is changed by $2"; return; fi
    if said=$(awk -v header="$1" -v prefix="$prefix" -v file="$file" -f tools/vocabulary.awk src/README.md mutant); then
        fail "$1: not noticed: $2"
        return
    fi
    case $said in *"$3"*) passed=$((passed + 1)) ;; *) fail "$1: $2 is not called '$3' but $said" ;; esac
}

while IFS='|' read -r header expression text; do
    case $header in '' | '#'*) continue ;; esac
    noticed "${header% }" "${expression# }" "${text# }"
done << 'END'
# results, and what all headers have
rsm.h | s/"the data cannot be used"/"the data is bad"/| RSM_RESULTS does not begin with the twelve
rsm.h | /X(RSM_ERR_ORDER/d| RSM_RESULTS does not begin with the twelve
ism.h | s/X(ISM_ERR_LIMIT,/X(ISM_ERR_TOO_MUCH,/| ISM_RESULTS does not begin with the twelve
rsm.h | s/\bRSM_DEF\b/RSMDEF/| RSM_DEF
rsm.h | s/\bRSM_NO_SIMD\b/RSM_PLAIN/| has intrinsics and no RSM_NO_SIMD
csm.h | s/\bCOHSM_STATIC\b/CSM_STATIC/| has no COHSM_STATIC
envlights.h | s/\benvlt_result_text\b/envlt_error_text/| has no envlt_result_text
rsm.h | s/\brsm_get_info\b/rsm_query_info/| has no rsm_get_info
rsm.h | s/DEF void rsm_get_info/DEF rsm_result rsm_get_info/| returns nothing
# make, unmake
rsm.h | s/\brsm_map_create\b/rsm_map_make/| rsm_map_make
envshadow.h | s/\benvsh_maps_create\b/envsh_maps_new/| envsh_maps_new
gifilter.h | s/\bgifilt_free\b/gifilt_release/| gifilt_release
ism.h | s/\bism_free\b/ism_destroy/| ism_destroy
gl_backend/gl_rsm.h | s/\bglbk_rsm_map_free\b/glbk_rsm_map_delete/| glbk_rsm_map_delete
gifilter.h | s/\bgifilt_create\b/gifilt_build/| nothing is made by gifilt_create
rsm.h | s/\brsm_map_bytes\b/rsm_map_need/| has no rsm_map_bytes
lightsampling.h | /^LSAMP_DEF size_t lsamp_light_bytes/d| has no lsamp_light_bytes
envlights.h | s/\benvlt_gltf_bytes\b/envlt_gltf_length/| has no envlt_gltf_bytes
# services, settings
rsm.h | s/(\*alloc_fn)/(*allocate_fn)/| rsm_allocator is not the one
shadowfield.h | s/(\*parallel_for)(void \*user, size_t count,/(*parallel_for)(size_t count, void *user,/| sfield_system is not the one
gl_backend/gl_backend.h | s/\bglbk_system  *system;/glbk_system services;/| is not glbk_system system
gifilter.h | s/^    gifilt_system *system;.*//| is not gifilt_system system
ism.h | s/const ism_system \*system/const ism_system *services/| is called system elsewhere
rsm.h | s/^RSM_DEF size_t rsm_map_bytes/RSM_DEF rsm_desc rsm_desc_defaults(void);\n&/| _defaults
csm.h | s/^COHSM_DEF void cohsm_free/COHSM_DEF cohsm_query cohsm_query_default(void);\n&/| _default
# receivers, meshes
rsm.h | s/\bnormal_stride\b/normal_step/| rsm_points does not begin with the members
lightsampling.h | s/^    size_t *position_stride;.*//| lsamp_points does not begin with the members
rsm.h | s/\brsm_points\b/rsm_receivers/| begins like receivers and is not called rsm_points
ism.h | s/\bism_points\b/ism_view/| begins like receivers and is not called ism_points
rsm.h | s/\brsm_mesh\b/rsm_geometry/| begins like a mesh and is not called rsm_mesh
shadowfield.h | s/const uint16_t \*indices16;/const uint16_t *short_indices;/| sfield_mesh does not begin with the members
csm.h | s/^    size_t *vertex_count;/    size_t vertices;/| cohsm_mesh does not begin with the members
# sizes
rsm.h | s/^    uint32_t       side; /    uint32_t       resolution; /| resolution
rsm.h | s/^    uint32_t       side; /    uint32_t       size; /| size
envshadow.h | s/\bmap_side\b/map_size/| map_size
rsm.h | s/\bopen_stride\b/open_pitch/| open_pitch
rsm.h | s/^    const float *\*open;/    const float *occlusion;/| occlusion: a share of light that arrives is called open
rsm.h | s/\btexel_count\b/num_texels/| num_texels
rsm.h | s/\bface_count\b/faces/| faces is a number of elements
rsm.h | s/\bmemory_bytes\b/memory_size/| memory_size
gl_backend/gl_csm.h | s/\btexel_count;/texels;/| texels is a number of elements
# angles
rsm.h | s/\bcone_half_angle\b/cone_deg/| cone_deg
lightsampling.h | s/\bcone_half_angle\b/cone_angle/| cone_angle
rsm.h | s/\bcone_half_angle\b/half_angle_degrees/| half_angle_degrees
# rows, clip space
rsm.h | s/\brsm_rows  *rows;/int            rows;/| rows is no rsm_rows
rsm.h | s/\brsm_rows\b/rsm_row_order/| rsm_row_order
gifilter.h | s/\bgifilt_rows\b/gifilt_top/| gifilt_top
rsm.h | s/\brsm_clip_depth\b/rsm_depth_range/| rsm_depth_range
envshadow.h | s/\bclip_depth;/depth_range;/| depth_range
envshadow.h | s/\benvsh_clip_depth\b/envsh_z_range/| envsh_z_range
rsm.h | s/\brsm_clip_y\b/rsm_up/| rsm_up
rsm.h | s/RSM_CLIP_DEPTH_REVERSED, .*//| has not the values of the table
# enums, kinds
rsm.h | s/^    RSM_LIGHT_DEFAULT, .*//| begins with RSM_LIGHT_SUN
rsm.h | s/^    RSM_LIGHT_COUNT$/    RSM_LIGHT_END/| ends with RSM_LIGHT_END
rsm.h | s/^    rsm_light_kind kind;/    rsm_light_kind type;/| type
rsm.h | s/\brsm_light_kind\b/rsm_light_type/| rsm_light_type
# matrices, directions, interleaving
rsm.h | s/\bworld_to_clip\b/view_projection/| view_projection
envshadow.h | s/\bworld_to_clip\b/clip/| clip: the table has another word
ism.h | s/float \([ a-z*]*\)world_to_clip\[16\]/float \1camera_matrix[16]/| camera_matrix
lightsampling.h | s/\bto_eye\b/views/| to_eye
ism.h | s/\bgeometric_normals\b/geometric/| geometric: the table has another word
ism.h | s/\binterleave\b/pattern/| interleave
rsm.h | s/\binterleave\b/interleaving/| interleave
shadowfield.h | s/sfield_scene_turn(sfield_scene \*scene, const float to_world/sfield_scene_turn(sfield_scene *scene, const float rotation/| the matrix rotation
lightsampling.h | s/const float to_eye\[3\]/const float wo[3]/| another word for wo
# words with one meaning
shadowfield.h | s/const uint8_t *\*in_view;/const uint8_t *visible;/| what the camera sees is in_view
lightsampling.h | s/const float \*visible, float \*radiance/const float *visibility, float *radiance/| the answers for samples
ism.h | s/^    float edge; /    float side; /| a length in the world
envshadow.h | s/\benvsh_views\b/envsh_get_views/| there is no type envsh_views
# callbacks
rsm.h | s/(\*surface_fn)/(*surface)/| surface has no _fn
envshadow.h | s/\benvsh_draw_fn\b/envsh_draw/| envsh_draw has no _fn
envshadow.h | s/\benvsh_draw_fn draw_fn\b/envsh_draw_fn draw/| draw has no _fn
rsm.h | s/^    void           \*user;  .*surface_fn.*//| the callback surface_fn has no user
# words
csm.h | s/^typedef struct cohsm_view /typedef struct cohsm_camera /| camera
gl_backend/gl_envshadow.h | s/\bviews;/cameras;/| cameras
gl_backend/gl_envshadow.h | s/\bglbk_envsh_cast\b/glbk_envsh_occlude/| _occlude
envshadow.h | s/\bcasters\b/occluders/; s/\bcaster\b/occluder/; s/envsh_maps_begin(envsh_maps \*maps/&, int occluder/| occluder
rsm.h | s/^    rsm_light      light;/    rsm_light      lamp;/| lamp
END

# The headers as they are have no breach; old names are found wherever somebody reads them.
for header in $(cd "$root" && ls *.h gl_backend/*.h); do cp "$root/$header" "$dir/$header"; done
if sh tools/check-vocabulary *.h gl_backend/*.h > log 2>&1; then passed=$((passed + 1)); else fail 'a header as it is'; cat log; fi
cp "$root/CHANGELOG.md" "$dir"
for line in 'rsm_filter_create(1)' 'the field ism_shading.pattern' 'GLBK_CSM_ASK_DISTANT' '/* cohsm_emitter_desc */'; do
    echo "$line" > docs/page.md
    if sh tools/check-vocabulary *.h gl_backend/*.h > log 2>&1 || ! grep -q 'docs/page.md:1:' log; then fail "not noticed: $line"
    else passed=$((passed + 1)); fi
done

echo "vocabulary: $passed passed, $failed failed, 0 skipped"
[ -n "$TOTALS" ] && echo "$passed $failed 0" >> "$TOTALS"
[ $failed = 0 ]
