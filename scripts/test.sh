#!/usr/bin/env bash
# Sets everything up, then runs the linter, the type checker and the tests: all three, whatever
# the others say, and fails if one does.
# --long runs the minutes-long tests too; other arguments go to pytest, which shares the files of
# tests between two processes (-n 0: none but itself).
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bash "$here/setup.sh" dev,viewer,crosscheck,movie,scenes,cluster,tables,slmsuite libegl1 libgl1 libgl1-mesa-dri libegl-mesa0 xvfb xauth \
    xserver-xorg-core xserver-xorg-video-dummy x11-xserver-utils x11-utils xdotool wmctrl imagemagick assimp-testmodels dbus metacity openbox
cd "$here/.."
marks=()
if [ "${1:-}" = "--long" ]; then
    marks=(-m "long or not long" --timeout 3600)
    shift
fi
failed=()
.venv/bin/ruff check . || failed+=("ruff check")
.venv/bin/ruff format --check . || failed+=("ruff format")
.venv/bin/mypy || failed+=(mypy)
.venv/bin/python -m pytest -n auto --maxprocesses 2 --dist loadfile "${marks[@]}" "$@" || failed+=(pytest)
if [ ${#failed[@]} -gt 0 ]; then
    printf -v names '%s, ' "${failed[@]}"
    echo "failed: ${names%, }" >&2
    exit 1
fi
