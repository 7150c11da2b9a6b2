#!/usr/bin/env bash
# Proves that the state hashes do not depend on how the program is built: builds `ac-conform` in several ways and checks
# `golden-traces/hashes.txt` with each, with one and with all threads.
#
#   scripts/hash-matrix.sh [VARIANT…]      variants: dev release fma native (default: all)
#
#   dev      the profile of `cargo test`
#   release  what is shipped: the baseline of the target
#   fma      release with AVX2 and fused multiply-add allowed: the compiler must not use it to merge roundings
#   native   release with everything that this processor has
#
# `fma` and `native` need a processor that has these. They are built in a temporary folder, which is removed at the end (about 1 GB).
set -euo pipefail
cd "$(dirname "$0")/.."

scratch=$(mktemp -d "${TMPDIR:-/tmp}/hash-matrix.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
failed=0

build() { # VARIANT; prints the path of the program
    local target=target profile=release flags=
    case $1 in
        dev) profile=dev ;;
        release) ;;
        fma) flags="-C target-feature=+avx2,+fma" target=$scratch/fma ;;
        native) flags="-C target-cpu=native" target=$scratch/native ;;
        *) echo "unknown variant: $1 (dev, release, fma, native)" >&2; exit 2 ;;
    esac
    RUSTFLAGS="$flags" cargo build --quiet --locked -p ac-conformance --profile "$profile" --target-dir "$target" >&2
    echo "$target/${profile/dev/debug}/ac-conform"
}

for variant in "${@:-dev release fma native}"; do
    # The default is one word of four.
    for name in $variant; do
        program=$(build "$name")
        for jobs in 1 0; do
            if "$program" hash --jobs "$jobs" --check golden-traces/hashes.txt > "$scratch/out"; then
                verdict=same
            else
                verdict=DIFFERS failed=1
                cat "$scratch/out" >&2
            fi
            threads=$([ "$jobs" = 0 ] && echo "all threads" || echo "one thread")
            echo "$name, $threads: $verdict ($(tail -n 1 "$scratch/out"))"
        done
        # Room for the next one.
        rm -rf "$scratch/$name"
    done
done
exit "$failed"
