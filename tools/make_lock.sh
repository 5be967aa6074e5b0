#!/bin/sh
# Resolve requirements.in into requirements.txt: one lock for Linux on x86-64 and every Python from 3.10 on.
# Needs uv (python3 -m pip install uv). Run it after a change of requirements.in, then `make test`.
set -eu
cd "$(dirname "$0")"
uv pip compile --quiet --no-python-downloads --universal --python-version 3.10 --upgrade \
  --annotation-style line --no-header requirements.in |
  sed -E -e "/sys_platform == 'win32'/d" \
    -e "s/ ; (sys_platform|platform_python_implementation) [!=]= '[a-zA-Z0-9]+'//" > requirements.new
{
  echo "# Lock of requirements.in, made by make_lock.sh: change that file, not this one."
  cat requirements.new
} > requirements.txt
rm requirements.new
