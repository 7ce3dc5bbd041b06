#!/usr/bin/env bash
# Builds the Debian package, installs it in a fresh Debian 12, starts the server there as its unit does, upgrades, removes and
# purges it. Needs root, and a mirror of Debian (DEBIAN_MIRROR).
#   scripts/package_test.sh [PACKAGE.deb]   with a package: tests it in place of building one
set -euo pipefail
cd "$(dirname "$0")/.."

fail() { echo "FAILED: $*" >&2; exit 1; }
step() { echo "== $*"; }

build() {
  cmake --preset release -D CORNERFIX_BUILD_TESTS=OFF -D CORNERFIX_BUILD_BENCH=OFF >/dev/null
  cmake --build --preset release
  rm -f build/release/cornerfix_*.deb
  cpack --preset release
  package=$(echo build/release/cornerfix_*.deb)
}

[[ $(id -u) -eq 0 ]] || fail "run it as root, for debootstrap and chroot"
scripts/install_dependencies.sh package
package=${1:-}
[[ -n $package ]] || build

root=$(mktemp -d)
chmod 755 "$root"  # The service user has to pass it.
trap 'rm -rf --one-file-system "$root" "$root.log"' EXIT
in_root() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive LC_ALL=C "$@"; }
apt() { in_root apt-get -qq -y "$@" >"$root.log" 2>&1 || { cat "$root.log"; fail "apt-get $*"; }; }
# In a network and a table of processes of its own: the port is free there, and no process outlives the step.
serve_and_check() {
  unshare --net --mount --pid --fork bash -euc '
    ip link set lo up
    mount -t proc proc "$0/proc"
    exec chroot "$0" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C /package_check.sh "$@"' "$root" "$@" || fail "the server: $*"
}
has_file() { [[ -e $root$1 ]] || fail "$1 is missing"; }
has_no_file() { [[ ! -e $root$1 ]] || fail "$1 is still there"; }
owner_and_mode() { in_root stat -c '%U %a' "$1"; }

step "Debian 12"
debootstrap --variant=minbase --include=curl bookworm "$root" "${DEBIAN_MIRROR:-http://deb.debian.org/debian}" >"$root.log" 2>&1 ||
  { tail "$root.log"; fail "debootstrap"; }
install -m 755 scripts/package_check.sh "$root/package_check.sh"
printf '#!/bin/sh\nexit 101\n' >"$root/usr/sbin/policy-rc.d"
chmod 755 "$root/usr/sbin/policy-rc.d"
cp "$package" "$root/cornerfix.deb"

step "install"
apt install --no-install-recommends /cornerfix.deb
[[ $(owner_and_mode /etc/cornerfix/config.json) == "cornerfix 600" ]] || fail "others can read the configuration"
[[ $(owner_and_mode /var/lib/cornerfix) == "cornerfix 750" ]] || fail "others can read the maps"
[[ -L $root/etc/systemd/system/multi-user.target.wants/cornerfix.service ]] || fail "the unit is not enabled"
for page in cornerfix cornerfix-serve cornerfix-map-build cornerfix-token-create; do has_file "/usr/share/man/man1/$page.1.gz"; done

step "start, and stop"
serve_and_check 8080

step "upgrade with a changed configuration"
sed -i 's/8080/8081/' "$root/etc/cornerfix/config.json"
in_root dpkg --install /cornerfix.deb >"$root.log" 2>&1 || { cat "$root.log"; fail "dpkg --install"; }
[[ $(owner_and_mode /etc/cornerfix/config.json) == "cornerfix 600" ]] || fail "the upgrade opened the configuration"
serve_and_check 8081

step "remove"
apt remove cornerfix
has_no_file /usr/bin/cornerfix
has_file /etc/cornerfix/config.json
has_file /var/lib/cornerfix/cornerfix.db

step "purge"
apt purge cornerfix
has_no_file /etc/cornerfix
has_file /var/lib/cornerfix/cornerfix.db
in_root getent passwd cornerfix >/dev/null || fail "the maps lost their owner"
[[ -z $(find "$root/etc/systemd" "$root/var/lib/systemd" -name '*cornerfix*') ]] || fail "the unit is still enabled or masked"
echo "passed: $(basename "$package"), $(($(stat -c %s "$package") / 1024)) KiB"
