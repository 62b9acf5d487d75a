#!/bin/bash
# Clones the last commit into a bare Debian 12 (minbase with git, make and ca-certificates) and makes
# the targets there, each timed. Shows that a fresh clone needs no preparation.
# Needs root and mmdebstrap. Usage: tests/docker/bare_debian.sh [--user] [TARGET...]
#   --user    as a user with sudo instead of as root
#   TARGET    of the Makefile; `run test` when none is given
set -euo pipefail
repository=$(git -C "$(dirname "$0")" rev-parse --show-toplevel)
packages=git,make,ca-certificates
user=root
if [ "${1:-}" = --user ]; then
  user=visitor packages+=,sudo
  shift
fi
targets=("$@")
[ $# -gt 0 ] || targets=(run test)

root=$(mktemp -d -t bare-debian.XXXXXX)
trap 'rm -rf --one-file-system "$root"' EXIT
mmdebstrap --quiet --variant=minbase --include=$packages bookworm "$root"
cp --dereference /etc/resolv.conf /etc/hosts "$root/etc/"
mkdir "$root/repository"

cat > "$root/try" <<'TRY'
#!/bin/bash
set -euo pipefail
cd
git config --global --add safe.directory '*'
git clone --quiet /repository stiefel
cd stiefel
TIMEFORMAT='%R s'
for target in "$@"; do
  echo "=== make $target"
  time make --no-print-directory "$target" </dev/null
done
TRY
chmod 755 "$root" "$root/try"
if [ $user != root ]; then
  chroot "$root" useradd --create-home $user
  echo "$user ALL=(ALL) NOPASSWD: ALL" > "$root/etc/sudoers.d/$user"
fi

# Separate namespaces, so that mounts and processes end with the script.
unshare --mount --pid --fork --kill-child /bin/bash -euo pipefail -c '
  root=$1 repository=$2 user=$3
  shift 3
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
  mount -t tmpfs tmpfs "$root/dev/shm"
  mount --bind -o ro "$repository" "$root/repository"
  cd /
  exec chroot "$root" /usr/bin/env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
    su --login "$user" -c "/try $*"
' - "$root" "$repository" $user "${targets[@]}"
