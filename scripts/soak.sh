#!/usr/bin/env bash
# Lets play, live and generate run long, headless, and prints their memory, handles and threads.
# usage: soak.sh [--minutes N]   minutes of each [60]; status 1 when one of them grows
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python=.venv/bin/python
[ -x "$python" ] || python=python3
exec "$python" tests/soaking.py "$@"
