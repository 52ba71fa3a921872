#!/bin/sh
# Installs what building and testing tetrakis needs on Debian 12, as far as it is missing.
#   tools/install_deps.sh            library, program and tests
#   tools/install_deps.sh --bench    also the peers of the benchmarks
#   tools/install_deps.sh --figures  also what tools/figures.sh draws with
#   tools/install_deps.sh --viewer   also what tools/viewer and its test need
#   tools/install_deps.sh --gdal     also what TETRAKIS_GDAL needs
#   tools/install_deps.sh --ci       also what the checks of .ci/run need
# Does nothing, in a fraction of a second, where everything is there.
set -eu

required="g++ cmake ninja-build libglm-dev libembree-dev libtbb-dev libfmt-dev libeigen3-dev \
libcli11-dev nlohmann-json3-dev libstb-dev libtinygltf-dev doctest-dev zlib1g-dev python3"
# Without these the build works and says what it leaves out: the comparison with OpenSubdiv, a faster rebuild, the viewer.
optional="libosd-dev ccache"
# xvfb-run asks for xauth, which Debian only recommends.
viewer="pkg-config libglfw3-dev libepoxy-dev libimgui-dev xvfb xauth libgl1-mesa-dri"
figures="python3-pil fonts-dejavu-core libmeshoptimizer-dev"
for argument in "$@"; do
    case "$argument" in
        --bench) optional="$optional libcgal-dev libopenmesh-dev libmeshoptimizer-dev libbenchmark-dev libp4est-dev \
libopenmpi-dev openmpi-bin" ;;
        --figures) required="$required $figures" ;;
        --viewer) optional="$optional $viewer" ;;
        --gdal) required="$required libgdal-dev" ;;
        --ci) required="$required clang-format $figures"; optional="$optional $viewer" ;;
        *) echo "usage: $0 [--bench] [--figures] [--viewer] [--gdal] [--ci]" >&2; exit 2 ;;
    esac
done

if ! command -v dpkg-query >/dev/null 2>&1; then
    echo "install_deps: this is no Debian; install by your own means: $required; optional: $optional" >&2
    exit 0
fi

# missing PACKAGE...: those that are not installed
missing() {
    # shellcheck disable=SC2086
    installed=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "$@" 2>/dev/null | sed -n 's/^installed //p')
    for package in "$@"; do
        echo "$installed" | grep -qxF "$package" || echo "$package"
    done
}

# shellcheck disable=SC2086
need=$(missing $required)
# shellcheck disable=SC2086
want=$(missing $optional)
if [ -z "$need" ] && [ -z "$want" ]; then
    exit 0
fi

if [ "$(id -u)" -eq 0 ]; then
    as_root=env
elif command -v sudo >/dev/null 2>&1; then
    as_root="sudo env"
elif [ -z "$need" ]; then
    echo "install_deps: going on without" $want "(no root, no sudo)" >&2
    exit 0
else
    echo "install_deps: neither root nor sudo; ask an administrator to run: apt-get install" $need $want >&2
    exit 1
fi
apt_get() {
    $as_root DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 "$@"
}

echo "install_deps: installing" $need $want >&2
if ! apt_get update >&2; then
    echo "install_deps: apt-get update failed; trying with the package lists that are there" >&2
fi
# All at once takes the least time. Where that fails, what is needed, and of the rest what there is.
# shellcheck disable=SC2086
if apt_get install -y --no-install-recommends $need $want >&2; then
    exit 0
fi
# shellcheck disable=SC2086
if [ -n "$need" ]; then
    apt_get install -y --no-install-recommends $need >&2
fi
for package in $want; do
    apt_get install -y --no-install-recommends "$package" >&2 ||
        echo "install_deps: $package could not be installed; what needs it is left out" >&2
done
