#!/bin/bash
# snakemake.sh GNOMON SOURCE: data/cluster/Snakefile with two shards at once against a single run, byte for byte. Exits with
# 77 where Snakemake is not installed.
set -eu
gnomon=$(realpath "$1")
source=$(realpath "$2")
. "$source/tests/cluster/study.sh"
need snakemake

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
export HOME=$work XDG_CACHE_HOME=$work/cache # where Snakemake keeps what it remembers
write_study study.json
"$gnomon" study run study.json --output single
flow() {
    timeout 240 snakemake --snakefile "$source/data/cluster/Snakefile" --cores 2 --nocolor "$@" \
        --config study="$work/study.json" out=flow shards=2 gnomon="$gnomon" >log 2>&1 || { cat log >&2; exit 1; }
}
flow
check_same flow single
grep -q "3 of 3 steps" log || { cat log >&2; exit 1; }

# Asked again it does nothing; forced, gnomon finds every cell there.
flow
grep -q "Nothing to be done" log || { cat log >&2; exit 1; }
flow --forceall
check_same flow single
[ "$(grep -c "nothing to do" log)" -eq 2 ] || { cat log >&2; exit 1; }
