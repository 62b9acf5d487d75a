#!/bin/sh
# Installs the missing Debian packages of the given kinds in packages.txt. It unpacks those of the kind `daemon` into
# build/daemons instead, and installs the libraries that they need: Debian starts an installed daemon at once and whenever
# the machine starts.
# Usage: docker/packages.sh KIND...
set -eu
here=$(dirname "$0")
daemons=$here/../build/daemons
list=$here/packages.txt
[ -r "$list" ] || { echo "$0: cannot read $list" >&2; exit 1; }

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

# Whether a package with one of the names "A|B" is installed.
installed() {
  for name in $(echo "$1" | tr '|' ' '); do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null)" != installed ] || return 0
  done
  return 1
}

# Prints the first of the names "A|B" that apt offers. Of a package that others only provide apt-cache prints nothing.
offered() {
  for name in $(echo "$1" | tr '|' ' '); do
    ! apt-cache show "$name" 2>/dev/null | grep -q . || { echo "$name"; return; }
  done
  echo "apt offers no package $1" >&2
  return 1
}

# Downloads the one package into the current folder. The sandbox's user may not write there.
download() { apt-get download -qq -o APT::Sandbox::User=root "$1" 2>/dev/null; }

missing=
for kind in "$@"; do
  for names in $(sed -n "s/^$kind //p" "$list" | tr ' ' '|'); do
    if [ "$kind" != daemon ]; then
      installed "$names" || missing="$missing $names"
      continue
    fi
    if [ ! -d "$daemons/$names" ]; then
      echo "Unpacking the Debian package $names into build/daemons"
      mkdir -p "$daemons"
      part=$(mktemp -d "$daemons/part.XXXXXX")
      (cd "$part" && { download "$names" || { as_root apt-get update -qq && download "$names"; } } \
       && dpkg-deb --extract ./*.deb . \
       && dpkg-deb --field ./*.deb Depends | tr ',' '\n' | sed -n '/^ *libjs-/d; s/^ *\(lib[^ ]*\).*/\1/p' >libraries \
       && rm ./*.deb && chmod 755 .)
      mv "$part" "$daemons/$names"
    fi
    for library in $(cat "$daemons/$names/libraries" 2>/dev/null); do
      installed "$library" || missing="$missing $library"
    done
  done
done

if [ -n "$missing" ]; then
  echo "Installing Debian packages:$missing"
  as_root apt-get update -qq
  chosen=
  for names in $missing; do
    case $names in *'|'*) names=$(offered "$names") ;; esac
    chosen="$chosen $names"
  done
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -qq --no-install-recommends \
    -o Dpkg::Use-Pty=0 $chosen >/dev/null
fi
