#!/usr/bin/env bash
# Sets everything up and runs `chrmc demo` with the arguments given.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bash "$here/setup.sh" viewer,scenes libegl1 libgl1 libgl1-mesa-dri libegl-mesa0
exec "$here/../.venv/bin/chrmc" demo "$@"
