#!/bin/bash
# Kills the server under load, at seeded moments, and checks every acknowledgement after each
# restart: scripts/crash_test.sh [ROUNDS] [SEED]
# Further runs store sessions every second only, and use PostgreSQL where it is installed.
# With FULL_DISK=1 a last run has its database on a tmpfs of 24 MB that is filled now and then;
# that needs the right to mount.
set -euo pipefail
cd "$(dirname "$0")/.."
rounds=${1:-100}
seed=${2:-1}
program=${CORNERFIX:-build/release/bin/cornerfix}

crash_test() { scripts/crash_test.py --program "$program" --rounds "$rounds" --seed "$seed" "$@"; }
crash_test
crash_test --checkpoint-interval 1 --longest 2
if compgen -G "/usr/lib/postgresql/*/bin" >/dev/null; then
  crash_test --postgresql
  crash_test --postgresql --checkpoint-interval 1 --longest 2
fi

if [[ ${FULL_DISK:-0} == 1 ]]; then
  disk=$(mktemp -d)
  mount -t tmpfs -o size=24m tmpfs "$disk"
  trap 'umount "$disk" && rmdir "$disk"' EXIT
  crash_test --full-disk "$disk"
fi
