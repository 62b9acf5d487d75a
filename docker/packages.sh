#!/bin/sh
# Installs the missing Debian packages of the given kinds in packages.txt.
# Usage: docker/packages.sh KIND...
set -eu
list=$(dirname "$0")/packages.txt

wanted=
for kind in "$@"; do
  wanted="$wanted $(awk -v kind="$kind" '$1 == kind { print $2 }' "$list")"
done

missing=
for package in $wanted; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

if [ "$(id -u)" = 0 ]; then
  as_root=env
elif command -v sudo >/dev/null; then
  as_root='sudo env'
else
  echo "These Debian packages are missing, and there is neither root nor sudo to install them:" >&2
  echo "  apt-get install --no-install-recommends$missing" >&2
  exit 1
fi
echo "Installing Debian packages:$missing"
$as_root apt-get update -qq
$as_root DEBIAN_FRONTEND=noninteractive apt-get install -qq --no-install-recommends \
  -o Dpkg::Use-Pty=0 $missing >/dev/null
