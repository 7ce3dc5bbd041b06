#!/usr/bin/env bash
# Makes docs/inspector.png from the real page: a simulated robot in the Willow Garage map.
#   scripts/screenshot.sh [CORNERFIX]   by default build/release/bin/cornerfix
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
/usr/bin/python3 -B tests/system/browser/robots_test.py --cornerfix "$(realpath "${1:-build/release/bin/cornerfix}")" \
  --map tests/data/willow_full_0.05.yaml --screenshots "$work" \
  RobotsTest.test_a_robot_becomes_localized_before_the_watchers_eyes
cp "$work/robot-localized.png" docs/inspector.png
