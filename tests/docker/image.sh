#!/bin/bash
# Builds the image and tests the running container: with the Docker engine if one answers, else with
# buildah and podman from Debian, as root, on a base made from Debian's packages. On Debian 12 the
# image takes the programs of build/release; elsewhere it compiles them.
# Usage: tests/docker/image.sh [pytest arguments]
#        tests/docker/image.sh --save FILE.tar.gz: writes the image for `docker load` in place of testing it
set -euo pipefail
cd "$(dirname "$0")/../.."
export STIEFEL_IMAGE=${STIEFEL_IMAGE:-stiefel} STIEFEL_IMAGE_BASE=debian:bookworm-slim
arguments=(--build-arg VERSION="$(awk '/^project\(stiefel VERSION/ { print $3 }' CMakeLists.txt)"
           --build-arg REVISION="$(git rev-parse HEAD)"
           -t "$STIEFEL_IMAGE" -f docker/Dockerfile)

release=$(. /etc/os-release; echo "${ID:-} ${VERSION_CODENAME:-}")
if [ "$release" = 'debian bookworm' ]; then
  make --no-print-directory build-programs
  rm -rf build/image
  cmake --install build/release --component runtime --strip --prefix "$PWD/build/image" >/dev/null
  echo "The image takes its programs from build/release: this is Debian bookworm, as is its base"
  arguments+=(--target prebuilt)
else
  make --no-print-directory build-python  # for the tests
  echo "The image compiles its programs: this is $release, its base is Debian bookworm"
fi
arguments+=(.)

# A separate image store, created if it is missing, so that the machine's own images stay untouched.
local_engine() {
  local store=${XDG_CACHE_HOME:-$HOME/.cache}/stiefel/containers open_files
  mkdir -p "$store"
  open_files=$(ulimit -Hn)
  cat > "$store/containers.conf" <<CONF
[containers]
default_ulimits = ["nofile=$open_files:$open_files", "nproc=4096:4096"]
[engine]
runtime = "runc"
cgroup_manager = "cgroupfs"
events_logger = "file"
CONF
  cat > "$store/storage.conf" <<CONF
[storage]
driver = "overlay"
graphroot = "$store/graph"
runroot = "$store/run"
CONF
  export CONTAINERS_CONF=$store/containers.conf CONTAINERS_STORAGE_CONF=$store/storage.conf
  if ! podman image exists "docker.io/library/$STIEFEL_IMAGE_BASE"; then
    echo "Making $STIEFEL_IMAGE_BASE from Debian's packages"
    # Slim like the published image: without manuals, translations and documentation except the
    # licences.
    mmdebstrap --quiet --variant=minbase \
      --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-include=/usr/share/doc/*/copyright' \
      --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/info/*' \
      --dpkgopt='path-exclude=/usr/share/locale/*' --dpkgopt='path-exclude=/usr/share/lintian/*' \
      --include=usr-is-merged \
      --customize-hook='chroot "$1" apt-get purge -qq usrmerge perl-modules-5.36 >/dev/null' \
      --customize-hook='rm -rf "$1"/var/lib/apt/lists/* "$1"/var/cache/*' \
      bookworm "$store/base.tar"
    podman import --quiet "$store/base.tar" "docker.io/library/$STIEFEL_IMAGE_BASE" >/dev/null
    rm "$store/base.tar"
  fi
}

if command -v docker >/dev/null && docker version >/dev/null 2>&1; then
  export CONTAINER_ENGINE=docker
  docker pull --quiet "$STIEFEL_IMAGE_BASE"
  docker build "${arguments[@]}"
else
  export CONTAINER_ENGINE=podman
  docker/packages.sh image
  local_engine
  buildah bud --force-rm --isolation chroot --pull-never --layers --format docker "${arguments[@]}"
fi
if [ "${1:-}" = --save ]; then
  # What has this name in podman is called "$STIEFEL_IMAGE" after `docker load`; its own name begins with localhost/.
  name=$STIEFEL_IMAGE
  [ "$CONTAINER_ENGINE" = docker ] || { name=docker.io/library/$name:latest; podman tag "$STIEFEL_IMAGE" "$name"; }
  "$CONTAINER_ENGINE" save "$name" | gzip -n > "$2"
  exit
fi
exec /usr/bin/python3 -m pytest -q -rA --no-header -p no:cacheprovider tests/docker "$@"
