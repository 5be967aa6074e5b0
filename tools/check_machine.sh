#!/bin/sh
# Name everything that is missing on this machine at once, with the one line that installs it.
# Usage: tools/check_machine.sh [PYTHON [--ros-sourced]]     (exit status 1 where something is missing)
# Plain sh: it runs where nothing is installed yet.
python=${1:-python3}
package=${python##*/}
problems=""
packages=""

lacks() { # DESCRIPTION PACKAGE
  problems="$problems
  - $1"
  case " $packages " in *" $2 "*) ;; *) packages="$packages $2" ;; esac
}

command -v make >/dev/null 2>&1 || lacks "make" make
command -v c++ >/dev/null 2>&1 || command -v g++ >/dev/null 2>&1 || lacks "a C++ compiler (it builds friction_msgs)" g++

if ! command -v "$python" >/dev/null 2>&1; then
  lacks "$python (version 3.10 to 3.14)" "$package"
  lacks "venv for $python" "$package-venv"
  lacks "the C headers of $python" "$package-dev"
elif ! "$python" -c 'import sys; sys.exit(not (3, 10) <= sys.version_info < (3, 15))'; then
  echo "$python is $("$python" --version 2>&1): ROS 2 Jazzy has wheels for Python 3.10 to 3.14." >&2
  echo "Name another one: make PYTHON=python3.12 ..." >&2
  exit 1
else
  "$python" -c 'import venv, ensurepip' >/dev/null 2>&1 || lacks "venv for $python" "$package-venv"
  "$python" -c 'import pathlib, sys, sysconfig
sys.exit(not pathlib.Path(sysconfig.get_path("include"), "Python.h").is_file())' ||
    lacks "the C headers of $python (Python.h)" "$package-dev"
fi

if [ -n "$problems" ]; then
  echo "This machine lacks:$problems
One line installs them all (Debian, Ubuntu):
  sudo apt-get install -y$packages" >&2
fi
if [ "${2-}" != --ros-sourced ] && [ "$(uname -s) $(uname -m)" != "Linux x86_64" ]; then
  echo "The ROS 2 wheels are for Linux on x86-64; this is $(uname -s) on $(uname -m).
Here, install ROS 2 Jazzy with apt, source /opt/ros/jazzy/setup.bash and come back." >&2
  exit 1
fi
[ -z "$problems" ]
