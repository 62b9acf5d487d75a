#!/bin/sh
# Installs the missing Debian packages of the given kinds in packages.txt. It unpacks those of the kind `daemon` into
# build/daemons instead: Debian starts an installed daemon at once and whenever the machine starts.
# Usage: docker/packages.sh KIND...
set -eu
here=$(dirname "$0")
top=$here/..
[ -r "$here/packages.txt" ] || { echo "$0: cannot read $here/packages.txt" >&2; exit 1; }
release=$(. /etc/os-release; echo "${VERSION_CODENAME:-}")

missing= packed=
for kind in "$@"; do
  for package in $(awk -v kind="$kind" -v release="$release" \
                       '$1 == kind && ($3 == "" || $3 == release) { print $2 }' "$here/packages.txt"); do
    status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
    if [ "$status" = installed ]; then
      continue
    elif [ "$kind" != daemon ]; then
      missing="$missing $package"
    elif [ ! -d "$top/build/daemons/$package" ]; then
      packed="$packed $package"
    fi
  done
done

as_root() {
  if [ "$(id -u)" = 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    echo "Neither root nor sudo is there to run: $*" >&2
    return 1
  fi
}

if [ -n "$missing" ]; then
  echo "Installing Debian packages:$missing"
  as_root apt-get update -qq
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -qq --no-install-recommends \
    -o Dpkg::Use-Pty=0 $missing >/dev/null
fi

# Downloads the one package into the current folder. The sandbox's user may not write there.
download() { apt-get download -qq -o APT::Sandbox::User=root "$1" 2>/dev/null; }

for package in $packed; do
  echo "Unpacking the Debian package $package into build/daemons"
  mkdir -p "$top/build/daemons"
  part=$(mktemp -d "$top/build/daemons/part.XXXXXX")
  (cd "$part" && { download "$package" || { as_root apt-get update -qq && download "$package"; } } \
   && dpkg-deb --extract ./*.deb . && rm ./*.deb && chmod 755 .)
  mv "$part" "$top/build/daemons/$package"
done
