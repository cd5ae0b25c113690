#!/bin/sh
# farm.sh - bakes spread over processes as docs/bake.md tells, by make -j, GNU parallel and, where slurmctld runs or can be
# started here, Slurm: the merged bytes are those of one process. Last line: "farm: N passed, N failed, N skipped".
build=${BUILD:-build}
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
passed=0 failed=0 skipped=0
BAKE=$PWD/$build/bake
export BAKE
settings='--set side=12 --set m=32'

check() {       # check NAME FILE
    if cmp -s "$dir/whole.csm" "$2"; then
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

if command -v sbatch >/dev/null 2>&1 && sinfo -h >/dev/null 2>&1; then
    # shellcheck disable=SC2086
    id=$(sbatch --parsable --wait --array=1-8 -o "$dir/slurm.log" examples/bake/farm.slurm csm builtin:knot "$dir/slurm.csm" $settings)
    # shellcheck disable=SC2046
    [ -n "$id" ] && "$BAKE" merge -o "$dir/slurm.csm" $(seq -f "$dir/slurm.csm.%gof8" 8)
    check 'Slurm' "$dir/slurm.csm"
else leave 'Slurm' 'no running slurmctld'; fi
echo "farm: $passed passed, $failed failed, $skipped skipped"
[ -n "$TOTALS" ] && echo "$passed $failed $skipped" >> "$TOTALS"
[ $failed = 0 ]
