#!/usr/bin/env bash
# Sets up a fresh Debian or Ubuntu: system packages that are missing, then .venv with chrmc in it.
# Run by demo.sh and test.sh.  usage: setup.sh EXTRAS PACKAGE…
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

extras=$1
shift

# Packages that are not there; nothing off Debian, where the user's own must do.
missing_of() {
    command -v dpkg-query >/dev/null || return 0
    local package
    for package in "$@"; do
        dpkg-query -W -f='${Status}\n' "$package" 2>/dev/null | grep -q "ok installed" ||
            echo "$package"
    done
}

# Installs what is missing. A user who may not is told what to ask for, and the rest goes on.
install_packages() {
    local missing as_root=()
    mapfile -t missing < <(missing_of "$@")
    [ ${#missing[@]} -eq 0 ] && return 0
    if [ "$(id -u)" -ne 0 ]; then
        as_root=(sudo)
        if ! command -v sudo >/dev/null || ! sudo -v 2>/dev/null; then
            echo "going on without what only root can install: apt-get install ${missing[*]}" >&2
            return 0
        fi
    fi
    echo "system packages through apt: ${missing[*]}"
    "${as_root[@]}" apt-get update -qq
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive LC_ALL=C \
        apt-get install -y -q --no-install-recommends "${missing[@]}" | sed -n '/^Need to get/p'
}

find_python() {
    local candidate
    for candidate in "${PYTHON:-}" python3 python3.14 python3.13 python3.12 python3.11; do
        if [ -n "$candidate" ] && command -v "$candidate" >/dev/null &&
            "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            echo "$candidate"
            return 0
        fi
    done
    echo "Python 3.11 or newer is needed: install python3 and python3-venv, or set PYTHON" >&2
    return 1
}

interpreter=()
command -v "${PYTHON:-python3}" >/dev/null || interpreter=(python3 python3-venv)
install_packages "$@" "${interpreter[@]}"
python=$(find_python) || exit 2
if [ ! -x .venv/bin/python ] || ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
    rm -rf .venv
    "$python" -m venv .venv >/dev/null 2>&1 || {
        rm -rf .venv
        install_packages python3-venv
        "$python" -m venv .venv >/dev/null || {
            rm -rf .venv
            echo "$python makes no virtual environment: install python3-venv" >&2
            exit 2
        }
    }
fi
# pip is asked again only when the project's needs have changed since.
pins=scripts/constraints.txt
stamp=.venv/.installed-${extras//,/-}
if [ ! -e "$stamp" ] || [ pyproject.toml -nt "$stamp" ] || [ "$pins" -nt "$stamp" ]; then
    constraints=() megabytes=120
    [[ ",$extras," == *,dev,* ]] && constraints=(-c "$pins") megabytes=200
    echo "Python packages into .venv ($("$python" --version)): about $megabytes MB, less what is there"
    # What is never imported need not be compiled, and the rest is when it is.
    PYTHONUNBUFFERED=1 .venv/bin/python -m pip install --progress-bar off --no-compile \
        "${constraints[@]}" -e ".[$extras]" | sed -un 's/^ *Downloading \(.*\)\.metadata .*//; s/^ *Downloading /  /p'
    touch "$stamp"
fi
