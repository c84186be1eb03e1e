#!/usr/bin/env bash
# Installs what is missing, then checks style, types and behaviour; further arguments go to pytest.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")"
bash scripts/install.sh

check() {
    local start=$SECONDS
    echo "== $*"
    .venv/bin/python -m "$@"
    echo "== $1: $((SECONDS - start)) s"
}

check ruff check .
check ruff format --check .
check mypy
check pytest -q -n auto --maxprocesses 4 --dist worksteal -m "not slow" "$@"
