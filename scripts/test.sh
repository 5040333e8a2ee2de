#!/usr/bin/env bash
# Sets everything up, then runs the linter, the type checker and the tests.
# --long runs the minutes-long tests too; other arguments go to pytest.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bash "$here/setup.sh" dev,viewer,crosscheck,movie libegl1 libgl1 libgl1-mesa-dri libegl-mesa0 xvfb xauth \
    xserver-xorg-core xserver-xorg-video-dummy x11-xserver-utils xdotool imagemagick
cd "$here/.."
marks=()
if [ "${1:-}" = "--long" ]; then
    marks=(-m "long or not long" --timeout 3600)
    shift
fi
.venv/bin/ruff check .
.venv/bin/ruff format --check .
.venv/bin/mypy
exec .venv/bin/python -m pytest "${marks[@]}" "$@"
