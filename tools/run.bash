#!/usr/bin/env bash
# Run a command in the environment of the workspace, whatever the calling shell has sourced; with --setup [PYTHON],
# check the machine and make that environment first, and run nothing.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# A prefix outside this repository that holds rclpy is a sourced ROS; our own .venv and install are not.
ros_prefix=""
IFS=: read -ra ros_prefixes <<< "${AMENT_PREFIX_PATH-}"
for candidate in "${ros_prefixes[@]}"; do
  [[ -d "$candidate/share/rclpy" && "$candidate" != "$root"/* ]] && ros_prefix=$candidate
done
if [[ -n $ros_prefix && ${ROS_DISTRO-} != jazzy ]]; then
  echo "ROS 2 ${ROS_DISTRO-of unknown name} is sourced ($ros_prefix); this workspace is for Jazzy." >&2
  echo "Open a shell that sources Jazzy, or none at all: then ROS comes from Python wheels." >&2
  exit 1
fi

if [[ ${1-} == --setup ]]; then
  python=${2:-python3}
  "$root/tools/check_machine.sh" "$python" ${ros_prefix:+--ros-sourced} || exit 1
  exec "$python" "$root/tools/make_venv.py" ${ros_prefix:+--ros-sourced}
fi

if [[ -z $ros_prefix ]]; then
  unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH PYTHONPATH PYTHONHOME LD_LIBRARY_PATH
  unset ROS_DISTRO RMW_IMPLEMENTATION VIRTUAL_ENV
  . "$root/.venv/setup.bash"
fi
[[ -f $root/install/setup.bash ]] && . "$root/install/setup.bash"
PATH=$root/.venv/bin:$PATH
exec "$@"
