#!/usr/bin/env bash
# Run a command in the environment of the workspace, whatever the calling shell has sourced.
. "$(dirname "$0")/environment.bash"
enter_workspace
exec "$@"
