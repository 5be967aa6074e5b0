#!/usr/bin/env bash
# `make setup`: check the machine, then make .venv. Usage: tools/setup.bash [PYTHON]
set -e
. "$(dirname "$0")/environment.bash"
python=${1:-python3}
if [[ -n $ros_prefix ]]; then
  "$root/tools/check_machine.sh" "$python" --ros-sourced
  exec "$python" "$root/tools/make_venv.py" --ros-sourced
fi
"$root/tools/check_machine.sh" "$python"
exec "$python" "$root/tools/make_venv.py"
