#!/bin/sh
# Draws the standard comparisons of subdivision schemes, factored steps and adaptive hierarchies as contact sheets:
# out/figures/*.png, and the meshes that they show as out/figures/meshes/*.glb. Installs what is missing (Debian 12) and
# builds first; then some minutes.
#   tools/figures.sh [SHEET...]         all sheets, or those that are named: curves, laves_tilings, rook, transitions, ...
# Environment: TETRAKIS_BUILD_DIR (build/release), TETRAKIS_JOBS (one per processor), TETRAKIS_FIGURES_DIR (out/figures),
# TETRAKIS_SHARED_DIR (../shared: has the scan of the bunny, whose pictures are left out without it).
set -eu
case "${1:-}" in
    -*) sed -n '2,7s/^# //p' "$0"; exit 2 ;;
esac
cd "$(dirname "$0")/.."
tools/install_deps.sh --figures

build=${TETRAKIS_BUILD_DIR:-build/release}
export CCACHE_BASEDIR="${CCACHE_BASEDIR:-$PWD}" CCACHE_NOHASHDIR="${CCACHE_NOHASHDIR:-1}"
if [ ! -f "$build/build.ninja" ]; then
    cmake --preset release -B "$build" -Wno-dev
fi
cmake --build "$build" --parallel "${TETRAKIS_JOBS:-$(nproc)}" --target tetrakis_cli figure_data

exec python3 tools/figures.py "$build" "${TETRAKIS_FIGURES_DIR:-out/figures}" "$@"
