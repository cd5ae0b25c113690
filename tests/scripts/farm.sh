#!/bin/sh
# farm.sh - bakes spread over processes as docs/bake.md tells, by make -j, GNU parallel and a Slurm of this machine
# alone (slurm.sh), into files of their own and into models: the merged bytes are those of one process. A farm that was
# killed goes on with the shards that it has. Last line: "farm: N passed, N failed, N skipped".
build=${BUILD:-build}
dir=$(mktemp -d) || exit 1
slurm=
end() {
    [ -z "$slurm" ] || kill "$slurm" 2>/dev/null && wait
    rm -rf "$dir"
}
trap end EXIT
trap 'exit 1' HUP INT TERM
passed=0 failed=0 skipped=0
BAKE=$PWD/$build/bake
export BAKE
settings='--set side=12 --set map_side=32'

check() {       # check NAME FILE [OTHER]: equal; without another file, to what one process has baked
    if cmp -s "${3:-$dir/whole.csm}" "$2"; then
        echo "  passed: $1"
        passed=$((passed + 1))
    else
        echo "  FAILED: $1"
        failed=$((failed + 1))
    fi
}
leave() {
    echo "  skipped: $1 ($2)"
    skipped=$((skipped + 1))
}

# shellcheck disable=SC2086
"$BAKE" csm builtin:knot -o "$dir/whole.csm" $settings || exit 1

make -s -j4 -f examples/bake/farm.mk OUT="$dir/make.csm" SCENE=builtin:knot SHARDS=8 SETTINGS="$settings" > "$dir/log" 2>&1 ||
    cat "$dir/log"
check 'make -j' "$dir/make.csm"

if command -v parallel >/dev/null 2>&1; then
    # shellcheck disable=SC2086
    seq 8 | parallel -j4 "$BAKE" csm builtin:knot -o "$dir/parallel.csm.{}of8" --shard '{}/8' --threads 1 $settings
    # shellcheck disable=SC2046
    "$BAKE" merge -o "$dir/parallel.csm" $(seq -f "$dir/parallel.csm.%gof8" 8)
    check 'GNU parallel' "$dir/parallel.csm"
else leave 'GNU parallel' 'not installed'; fi

# Into models, whose parts are joined with the model; and maps of places.
"$BAKE" model builtin:knot -o "$dir/knot.glb" || exit 1
ao='--engine csm --set side=16 --set map_side=32'
# shellcheck disable=SC2086
"$BAKE" ao "$dir/knot.glb" -o "$dir/whole-ao.glb" $ao || exit 1
farm() {        # farm OUT TECHNIQUE SCENE SHARDS SETTINGS
    make -s -j4 -f examples/bake/farm.mk OUT="$1" TECHNIQUE="$2" SCENE="$3" SHARDS="$4" SETTINGS="$5" > "$dir/log" 2>&1 ||
        cat "$dir/log"
}
farm "$dir/make-ao.glb" ao "$dir/knot.glb" 6 "$ao"
check 'make -j, ao' "$dir/make-ao.glb" "$dir/whole-ao.glb"
if command -v parallel >/dev/null 2>&1; then
    # shellcheck disable=SC2086
    seq 5 | parallel -j4 "$BAKE" ao "$dir/knot.glb" -o "$dir/parallel-ao.{}of5" --shard '{}/5' --threads 1 $ao
    # shellcheck disable=SC2046
    "$BAKE" merge -o "$dir/parallel-ao.glb" "$dir/knot.glb" $(seq -f "$dir/parallel-ao.%gof5" 5)
    check 'GNU parallel, ao' "$dir/parallel-ao.glb" "$dir/whole-ao.glb"
else leave 'GNU parallel, ao' 'not installed'; fi
places='--domain sphere:4,1,0,0.5 --set side=6 --set map_side=32'
# shellcheck disable=SC2086
"$BAKE" csm builtin:knot -o "$dir/whole-places.csm" $places || exit 1
farm "$dir/places.csm" csm builtin:knot 5 "$places"
check 'make -j, csm --domain' "$dir/places.csm" "$dir/whole-places.csm"
"$BAKE" shadowfield builtin:cornell -o "$dir/whole.sf" --set position_side=3 --set shell_count=5 --set kind=source || exit 1
farm "$dir/make.sf" shadowfield builtin:cornell 5 '--set position_side=3 --set shell_count=5 --set kind=source'
check 'make -j, shadowfield kind=source' "$dir/make.sf" "$dir/whole.sf"
if "$build/render" --list | grep -q '^  reference.*needs Embree'; then leave 'make -j, light' 'no Embree'
else
    light='--light sun:1,2,3,4 --set samples=8 --set directional=1'
    # shellcheck disable=SC2086
    "$BAKE" light "$dir/knot.glb" -o "$dir/whole-light.glb" $light || exit 1
    farm "$dir/make-light.glb" light "$dir/knot.glb" 6 "$light"
    check 'make -j, light' "$dir/make-light.glb" "$dir/whole-light.glb"
fi

# Killed outright once a shard is there: what is whole then is kept, and the rest is made by the same command.
if command -v setsid >/dev/null 2>&1; then
    slow='--engine csm --set side=48 --set map_side=128'
    # shellcheck disable=SC2086
    "$BAKE" ao "$dir/knot.glb" -o "$dir/whole-slow.glb" $slow || exit 1
    setsid make -s -j1 -f examples/bake/farm.mk OUT="$dir/killed.glb" TECHNIQUE=ao SCENE="$dir/knot.glb" SHARDS=6 \
        SETTINGS="$slow" > "$dir/log" 2>&1 &
    make=$!
    tries=0
    until [ -f "$dir/killed.glb.2of6" ] || [ $tries = 3000 ]; do sleep 0.02; tries=$((tries + 1)); done
    kill -9 "-$make"
    wait $make 2>/dev/null
    kept=$(cd "$dir" && ls killed.glb.[1-6]of6)
    # shellcheck disable=SC2086
    (cd "$dir" && ls -i $kept) > "$dir/before"
    if [ -f "$dir/killed.glb" ]; then rm "$dir/before"; fi         # it had ended
    farm "$dir/killed.glb" ao "$dir/knot.glb" 6 "$slow"
    # shellcheck disable=SC2086
    (cd "$dir" && ls -i $kept) > "$dir/after"
    check 'make -j, ao, killed' "$dir/killed.glb" "$dir/whole-slow.glb"
    check 'make -j, ao, killed: shards that were kept' "$dir/before" "$dir/after"
else leave 'a farm that is killed' 'no setsid'; fi

# The two commands at the head of farm.slurm; then, as after a node that was lost, one task again that had finished
# and one whose part is gone: the first keeps its part.
export settings ao
cat > "$dir/slurm" <<'END'
dir=$1
parts=$(seq -f "$dir/slurm.csm.%gof8" 8)
merge() {
    sbatch --parsable --dependency=afterok:"$id" --kill-on-invalid-dep=yes -o "$dir/merge.log" \
        --wrap "\"$BAKE\" merge -o \"$dir/$1.csm\" $(echo $parts)"
    tries=0
    until [ -z "$(squeue -h)" ] || [ $tries = 400 ]; do sleep 0.2; tries=$((tries + 1)); done
    cat "$dir"/merge.log "$dir"/task.*
}
id=$(sbatch --parsable --array=1-8 -o "$dir/task.%a" \
    examples/bake/farm.slurm csm builtin:knot "$dir/slurm.csm" $settings) || exit
merge slurm
ls -i "$dir/slurm.csm.3of8" > "$dir/before"
rm -f "$dir/slurm.csm.5of8"
scontrol requeue "${id}_[3,5]" || exit
scontrol update JobId="${id}_[3,5]" StartTime=now || exit       # not after two minutes
merge again
ls -i "$dir/slurm.csm.3of8" > "$dir/after"
id=$(sbatch --parsable --array=1-4 -o "$dir/task.%a" examples/bake/farm.slurm ao "$dir/knot.glb" "$dir/slurm-ao" $ao) || exit
parts="$dir/knot.glb $(seq -f "$dir/slurm-ao.%gof4" 4 | tr '\n' ' ')"
merge ao
mv "$dir/ao.csm" "$dir/slurm-ao.glb"
END
sh tests/scripts/slurm.sh sh "$dir/slurm" "$dir" > "$dir/log" 2>&1 &
slurm=$!
wait $slurm
status=$? slurm=
if [ $status = 77 ]; then leave 'Slurm' "$(sed -n 's/^skip: //p' "$dir/log")"
else
    check 'Slurm' "$dir/slurm.csm"
    check 'Slurm, two tasks again' "$dir/again.csm"
    check 'Slurm, a part that was kept' "$dir/before" "$dir/after"
    check 'Slurm, ao' "$dir/slurm-ao.glb" "$dir/whole-ao.glb"
    [ $failed = 0 ] || cat "$dir/log"
fi
echo "farm: $passed passed, $failed failed, $skipped skipped"
[ -n "$TOTALS" ] && echo "$passed $failed $skipped" >> "$TOTALS"
[ $failed = 0 ]
