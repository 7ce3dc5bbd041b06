#!/bin/bash
# Three servers on one PostgreSQL behind HAProxy, a paced fleet, and the faults that an operator
# fears. Prints a table; exits with 1 when a promise of docs/scaling.md is broken, and with 77 where
# PostgreSQL or HAProxy is not installed:
#   scripts/cluster_test.sh [--robots N] [--seconds S] [--rate BATCHES]
#   scripts/cluster_test.sh --throughput    # batches per second of 1, 2 and 3 servers
# A full disk needs the right to mount a tmpfs; else that fault is skipped.
set -euo pipefail
cd "$(dirname "$0")/.."
program=${CORNERFIX:-build/release/bin/cornerfix}
exec /usr/bin/python3 -B scripts/cluster_test.py --cornerfix "$program" "$@"
