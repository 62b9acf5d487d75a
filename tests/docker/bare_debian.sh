#!/bin/bash
# Clones the last commit into a bare Debian (minbase with git, make and ca-certificates) and makes the targets there,
# each timed. Shows that a fresh clone needs no preparation, and that no target enables a service or leaves one running.
# Needs root and mmdebstrap. Usage: tests/docker/bare_debian.sh [--suite SUITE] [--user] [TARGET...]
#   --suite   bookworm (Debian 12, the default) or trixie (13)
#   --user    as a user with sudo instead of as root
#   TARGET    of the Makefile; `run test` when none is given
set -euo pipefail
repository=$(git -C "$(dirname "$0")" rev-parse --show-toplevel)
packages=git,make,ca-certificates
suite=bookworm user=root
while [[ ${1:-} == --* ]]; do
  case $1 in
    --suite) suite=$2; shift 2 ;;
    --user) user=visitor packages+=,sudo; shift ;;
    *) echo "unknown: $1" >&2; exit 2 ;;
  esac
done
targets=("$@")
[ $# -gt 0 ] || targets=(run test)

root=$(mktemp -d -t bare-debian.XXXXXX)
trap 'rm -rf --one-file-system "$root"' EXIT
mmdebstrap --quiet --variant=minbase --include=$packages "$suite" "$root"
cp --dereference /etc/resolv.conf /etc/hosts "$root/etc/"
mkdir "$root/repository"

cat > "$root/try" <<'TRY'
#!/bin/bash
set -euo pipefail
# What starts with the machine, and the programs that run, without zombies: the first process does not reap orphans.
# Where systemd is not, a package starts what it has in init.d.
enabled() { find /etc/systemd /etc/rc[2-5].d -type l | sort; }
running() {
  awk '/^Name:/ {name = $2} /^State:/ && $2 != "Z" {print name}' /proc/[0-9]*/status 2>/dev/null |
    grep -vxE 'awk|mawk|diff|grep|sort|bash' | sort -u || true
}
cd
git config --global --add safe.directory '*'
git clone --quiet /repository stiefel
cd stiefel
before=$(enabled; running)
TIMEFORMAT='%R s'
for target in "$@"; do
  echo "=== make $target"
  time make --no-print-directory "$target" </dev/null
  diff <(echo "$before") <(enabled; running) || { echo "make $target enabled or left running what is marked >" >&2; exit 1; }
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
