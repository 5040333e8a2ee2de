#!/usr/bin/env bash
# Tries inputs that nobody would write on the commands, the readers of files and the functions for
# arrays; what fails is kept in tests/fuzzed, where a test tries it again.
# usage: fuzz.sh [--minutes N] [--cases N] [--seed S] [--kinds cli,files,arrays]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python=.venv/bin/python
[ -x "$python" ] || python=python3
exec "$python" tests/fuzzing.py "$@"
