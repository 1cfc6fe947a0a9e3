#!/bin/sh
# The learner and its page in one container; the learner is the process that Docker watches and ends.
# Variables: DATA, what survives updates (/data); PAGE_HOST and PAGE_PORT (0.0.0.0 and 9110). Names that begin with INCSVR_
# are values of the configuration.
set -eu
data=${DATA:-/data}
config=$data/config.yaml
# The vehicle's own configuration stays where updates of the image leave it; the first start lays one there.
[ -e "$config" ] || cp "$(dirname "$0")/config.yaml" "$config"
export INCSVR_STATE="${INCSVR_STATE:-$data/state}" OPENBLAS_NUM_THREADS=1
incsvr config check "$config"
incsvr page --config "$config" --host "${PAGE_HOST:-0.0.0.0}" --port "${PAGE_PORT:-9110}" &
exec incsvr serve --config "$config" --archive "$data/archive"
