#!/usr/bin/env bash
# Lets play, live and generate run long, headless, and prints their memory, handles, threads and
# OpenGL objects.
# usage: soak.sh [--minutes N] [--fps F]   minutes [60], frames a second of play and live [60]; status 1 when one of them grows
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python=.venv/bin/python
[ -x "$python" ] || python=python3
exec "$python" tests/soaking.py "$@"
