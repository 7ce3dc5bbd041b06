#!/usr/bin/env bash
# Makes docs/inspector.png and docs/inspector.gif from the real page (Debian: chromium-driver, python3-selenium,
# python3-pil).
#   scripts/screenshot.sh [CORNERFIX]   by default build/release/bin/cornerfix
set -euo pipefail
cd "$(dirname "$0")/.."
/usr/bin/python3 -B scripts/page_pictures.py --cornerfix "$(realpath "${1:-build/release/bin/cornerfix}")" --out docs
