# What the tests of clusters share: a study, and what must be the same whoever runs it. Sourced by bash.

need() {
    for program in "$@"; do
        command -v "$program" >/dev/null && continue
        echo "skipped: $program is not installed (bin/packages names its package)" >&2
        exit 77
    done
}

write_study() {
    cat >"$1" <<'END'
{
  "scenes": ["builtin:half-plane", "builtin:fence"],
  "sizes": ["64x36", "48x27"],
  "truth": {"samples": 64},
  "parameters": {"size": [64, 128]},
  "techniques": ["sm", "pcf:kernel=3", "vsm", "sv-zfail"]
}
END
}

# check_same FOLDER EXPECTED: all but times, bookkeeping of the engine and what only one of them needs.
check_same() {
    [ -s "$1/results.csv" ] || { echo "$1 has no tables" >&2; exit 1; }
    diff -r --exclude=timing.json --exclude='timings.*' --exclude=shards "$1" "$2"
    echo "$1 has the bytes of a single run: $(wc -l <"$1/results.jsonl") rows, $(ls "$1/cells" | wc -l) cells"
}
