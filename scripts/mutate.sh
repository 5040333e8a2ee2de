#!/usr/bin/env bash
# Makes small wrong changes to the core files, one at a time in a copy of the tree, and says what
# share of them the tests of each file catch.
# usage: mutate.sh [--minutes N] [--seed S] [--sample N] [GROUP …]     [all groups; --list names them]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python=.venv/bin/python
[ -x "$python" ] || python=python3
exec "$python" tests/mutation.py "$@"
