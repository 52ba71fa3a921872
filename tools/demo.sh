#!/bin/sh
# From a bare Debian 12 to a picture: installs what is missing, builds, and tessellates a chess rook to a thousandth of
# its size, by measurement and by proof. Meshes, reports and pictures go to out/.
#   tools/demo.sh [model.obj [tolerance]]        default: data/rook.obj 1e-3
#   tools/demo.sh lod [heights [options]]        a flight over hills in Tennessee, or over your heights (tetrakis lod --help)
# Environment: TETRAKIS_BUILD_DIR (build/release), TETRAKIS_JOBS (one per processor).
set -eu
case "${1:-}" in
    -*) sed -n '2,7s/^# //p' "$0"; exit 2 ;;
    lod)
        model=lod
        shift
        case "${1:-}" in
            '') set -- data/jacksboro.png --spacing 92.7 --pixels 0.5 --size 640x360 ;;
            /*) ;;
            *) heights=$PWD/$1 && shift && set -- "$heights" "$@" ;;
        esac ;;
    /* | '') model=${1:-data/rook.obj} ;;
    *) model=$PWD/$1 ;;
esac
tolerance=${2:-1e-3}
cd "$(dirname "$0")/.."
model=${model#"$PWD/"}
tools/install_deps.sh

build=${TETRAKIS_BUILD_DIR:-build/release}
# Lets ccache serve clones of the project in other folders, too.
export CCACHE_BASEDIR="${CCACHE_BASEDIR:-$PWD}" CCACHE_NOHASHDIR="${CCACHE_NOHASHDIR:-1}"
if [ ! -f "$build/build.ninja" ]; then
    cmake --preset release -B "$build" -Wno-dev
fi
cmake --build "$build" --parallel "${TETRAKIS_JOBS:-$(nproc)}" --target tetrakis_cli
tetrakis=$build/tetrakis

mkdir -p out
if [ "$model" = lod ]; then
    echo
    echo "== a flight over $1 =="
    "$tetrakis" lod "$@" --images 24 -o out/lod --report out/lod.json || [ $? -eq 4 ]
    echo
    echo "Look at out/lod/flight.png in a browser, which plays it, or at its frames in out/lod/sheet.png;"
    echo "out/lod/frames.csv says what each frame cost, out/lod.json the flight."
    exit 0
fi
name=$(basename "$model" .obj)
scheme=catmull-clark
case "$name" in *_tri) scheme=loop ;; esac

# tessellate ESTIMATOR FILE: exit code 4, a tolerance that was not reached, is worth seeing too.
tessellate() {
    echo
    echo "== $name, tolerance $tolerance, --estimator $1 =="
    "$tetrakis" tessellate "$model" --scheme "$scheme" --tolerance "$tolerance" --estimator "$1" \
        -o "out/$2.glb" --report "out/$2.json" --image "out/$2.png" --image-heat "out/$2_error.png" || [ $? -eq 4 ]
}
tessellate measured "$name"
tessellate certified "${name}_certified"
echo
echo "Look at out/$name.png (wireframe) and out/${name}_error.png (error); out/$name.json has the figures,"
echo "out/$name.glb the mesh. out/${name}_certified.* is the run with a proven bound."
