#!/bin/sh
# Remake the hashed lock files from the .in files; run in any folder, needs uv.
# Each larger lock is held to the versions of the smaller one.
set -eu
cd "$(dirname "$0")"
lock() {
    name=$1
    shift
    uv pip compile --quiet --universal --fork-strategy fewest --generate-hashes --python-version 3.11 \
        --no-header --no-emit-index-url --no-emit-find-links --no-annotate \
        "$@" --output-file "$name.txt" "$name.in"
}
lock demo
lock train --constraint demo.txt
lock dev --constraint train.txt
lock record --constraint dev.txt
lock compare --constraint dev.txt
