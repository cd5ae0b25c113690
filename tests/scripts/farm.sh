#!/bin/sh
# farm.sh - bakes spread over processes as docs/bake.md tells, by make -j, GNU parallel and a Slurm of this machine
# alone (slurm.sh): the merged bytes are those of one process. Last line: "farm: N passed, N failed, N skipped".
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

# The two commands at the head of farm.slurm; then, as after a node that was lost, one task again that had finished
# and one whose part is gone: the first keeps its part.
export settings
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
    [ $failed = 0 ] || cat "$dir/log"
fi
echo "farm: $passed passed, $failed failed, $skipped skipped"
[ -n "$TOTALS" ] && echo "$passed $failed $skipped" >> "$TOTALS"
[ $failed = 0 ]
