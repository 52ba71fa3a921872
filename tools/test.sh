#!/bin/sh
# Builds tetrakis and runs its tests, from a bare Debian 12 on. Of the figures one is drawn: to draw all of
# them run tools/install_deps.sh --figures, then ctest --test-dir build/release -L figures.
#   tools/test.sh [cmake options...]         e.g. tools/test.sh -DTETRAKIS_WERROR=ON
# Environment: TETRAKIS_PRESET (release), TETRAKIS_BUILD_DIR (build/<preset>), TETRAKIS_JOBS (one per processor).
set -eu
cd "$(dirname "$0")/.."
tools/install_deps.sh

preset=${TETRAKIS_PRESET:-release}
build=${TETRAKIS_BUILD_DIR:-build/$preset}
jobs=${TETRAKIS_JOBS:-$(nproc)}
# Lets ccache serve clones of the project in other folders, too.
export CCACHE_BASEDIR="${CCACHE_BASEDIR:-$PWD}" CCACHE_NOHASHDIR="${CCACHE_NOHASHDIR:-1}"

cmake --preset "$preset" -B "$build" -Wno-dev "$@"
cmake --build "$build" --parallel "$jobs"
exec ctest --test-dir "$build" --output-on-failure --parallel "$jobs" --timeout 900 --label-exclude not-in-ci
