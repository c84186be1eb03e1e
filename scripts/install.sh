#!/usr/bin/env bash
# From nothing to a working fbcouple on Debian 12 or 13: system packages, .venv at the root, the adapter.
# A step that is done is skipped. PYTHON names another interpreter (>= 3.11) for .venv; with NEWEST=1 Python packages are
# the newest that pyproject.toml allows, else those of scripts/constraints.txt.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# step TEXT COMMAND...: one line with the seconds it took; the command's last words only if it fails
step() {
    local text=$1 start=$SECONDS code=0
    shift
    printf '%s ... ' "$text"
    "$@" >"$log" 2>&1 || code=$?
    if [ "$code" -ne 0 ]; then
        printf 'failed after %d s\n' "$((SECONDS - start))"
        tail -n 30 "$log" >&2
        printf 'install.sh: failed with exit code %d: %s\n' "$code" "$*" >&2
        exit "$code"
    fi
    printf '%d s\n' "$((SECONDS - start))"
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

suitable_python() {
    "$1" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1
}

find_python() {
    local candidate
    for candidate in ${PYTHON:+"$PYTHON"} python3 /usr/bin/python3; do
        if suitable_python "$candidate"; then
            command -v "$candidate"
            return
        fi
    done
    return 1
}

wanted_packages() {
    local use package rest
    while read -r use package rest; do
        case "$use $package" in
            "#"* | " ") continue ;;
            *" openfoam") if [ -d "${WM_PROJECT_DIR:-}/src/OpenFOAM" ]; then continue; fi ;;
            *" liggghts") if [ -f "${FBCOUPLE_LIGGGHTS:-}" ]; then continue; fi ;;
            "python "*) if find_python >/dev/null; then continue; fi ;;
        esac
        printf '%s\n' "$package"
    done <fbcouple/doctor/system_packages.txt
}

missing_packages() {
    local package
    for package in $(wanted_packages); do
        dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || printf '%s\n' "$package"
    done
}

apt_install() {
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@"
}

# The package lists are only renewed if they are too old or empty to install from.
install_packages() {
    apt_install "$@" || { as_root apt-get update && apt_install "$@"; } || { explain_absent "$@" && return 1; }
}

# What else serves where the system's package lists have no such package.
explain_absent() {
    local package
    for package in "$@"; do
        if LC_ALL=C apt-cache policy "$package" | grep -q 'Candidate: [^(]'; then continue; fi
        printf '%s is not in the package lists of %s; ' "$package" "$(. /etc/os-release && printf '%s' "$PRETTY_NAME")"
        case "$package" in
            openfoam) echo "source the etc/bashrc of openfoam.com v1912 or later (its packages are on openfoam.com), then run this again" ;;
            liggghts) echo "build LIGGGHTS-PUBLIC 3.8 as a shared library and name it in FBCOUPLE_LIGGGHTS, then run this again" ;;
            *) echo "on Ubuntu: add-apt-repository universe" ;;
        esac
    done
}

system_packages() {
    local missing
    if ! command -v dpkg-query >/dev/null; then
        echo "system packages: no dpkg here, so nothing is installed; 'fbcouple doctor' says what is missing"
        return
    fi
    mapfile -t missing < <(missing_packages)
    if [ "${#missing[@]}" -eq 0 ]; then
        echo "system packages: all there"
        return
    fi
    if [ "$(id -u)" -ne 0 ] && ! command -v sudo >/dev/null; then
        administrator="apt-get install -y --no-install-recommends ${missing[*]}"
        echo "system packages: need an administrator; what needs none is done now"
        return
    fi
    step "system packages: ${missing[*]}" install_packages "${missing[@]}"
}

python_packages() {
    local python mark=.venv/installed-from stamp versions=(-c scripts/constraints.txt)
    if ! [ -x .venv/bin/python ]; then
        python=$(find_python) || {
            tell_administrator
            echo "install.sh: no Python >= 3.11 with venv here; or name one in PYTHON" >&2
            exit 1
        }
        step ".venv with $python" "$python" -m venv .venv
    fi
    if [ "${NEWEST:-0}" = 1 ]; then versions=(--upgrade --upgrade-strategy eager); fi
    stamp=$(cat pyproject.toml fbcouple/version.py scripts/constraints.txt <(printf '%s' "$root ${versions[*]}") | sha256sum)
    if [ -f "$mark" ] && [ "$(cat "$mark")" = "$stamp" ]; then
        echo "python packages: all there"
        return
    fi
    step "python packages: pip install -e .[dev]" .venv/bin/python -m pip install --quiet "${versions[@]}" -e '.[dev]'
    printf '%s\n' "$stamp" >"$mark"
}

# What is left where there is neither root nor sudo.
tell_administrator() {
    if [ -n "$administrator" ]; then
        echo "install.sh: one command is left for an administrator, then run this again: $administrator" >&2
    fi
}

administrator=
system_packages
python_packages
if [ -n "$administrator" ]; then
    tell_administrator
    exit 1
fi
step "adapter for OpenFOAM" .venv/bin/python -m fbcouple.solvers.openfoam.build
