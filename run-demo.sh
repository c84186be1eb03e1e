#!/usr/bin/env bash
# Installs what is missing, then runs the shipped demonstration case and draws its figures.
# A finished run is only drawn again, an unfinished one goes on from its checkpoint; --fresh begins anew.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")"
if [ "$#" -gt 1 ] || { [ "$#" -eq 1 ] && [ "$1" != --fresh ]; }; then
    echo "usage: run-demo.sh [--fresh]; found: $*" >&2
    exit 2
fi
fresh=${1:-}
run=runs/patil-demo
ranks=$(env -u OMP_NUM_THREADS nproc)
[ "$ranks" -le 2 ] || ranks=2

fbcouple() {
    local start=$SECONDS
    echo "== fbcouple $*"
    .venv/bin/fbcouple "$@"
    echo "== fbcouple $1: $((SECONDS - start)) s"
}

is_finished() {
    [ -f "$run/results.nc" ] && .venv/bin/python - "$run/results.nc" <<'PYTHON'
import sys

import xarray

with xarray.open_dataset(sys.argv[1]) as results:
    sys.exit(0 if int(results.attrs.get("complete", 0)) else 1)
PYTHON
}

bash scripts/install.sh
mkdir -p runs
if [ -z "$fresh" ] && is_finished; then
    echo "$run is finished: only its figures are drawn again (run-demo.sh --fresh runs it anew)"
else
    if [ -n "$fresh" ] || [ ! -f "$run/manifest.json" ]; then
        rm -rf "$run" # set-up replaces no run that has begun
        fbcouple setup patil/demo -o "$run"
    fi
    fbcouple run "$run" -n "$ranks" --resume
fi
fbcouple post "$run"
