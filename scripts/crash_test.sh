#!/bin/bash
# Kills the server under load, at seeded moments, and checks every acknowledgement after each
# restart: scripts/crash_test.sh [ROUNDS] [SEED]
# With FULL_DISK=1 a second run has its database on a tmpfs of 24 MB that is filled now and then;
# that needs the right to mount.
set -euo pipefail
cd "$(dirname "$0")/.."
rounds=${1:-100}
seed=${2:-1}
program=${CORNERFIX:-build/release/bin/cornerfix}

scripts/crash_test.py --program "$program" --rounds "$rounds" --seed "$seed"

if [[ ${FULL_DISK:-0} == 1 ]]; then
  disk=$(mktemp -d)
  mount -t tmpfs -o size=24m tmpfs "$disk"
  trap 'umount "$disk" && rmdir "$disk"' EXIT
  scripts/crash_test.py --program "$program" --rounds "$rounds" --seed "$seed" --full-disk "$disk"
fi
