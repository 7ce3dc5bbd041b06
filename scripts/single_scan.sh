#!/usr/bin/env bash
# The single-scan protocol on every log and in Willow Garage with 10 m range and 5 cm noise: one
# scan, the best pose counts. Prints a table. docs/evaluation.md, section 6, describes the figures.
#   scripts/single_scan.sh [DIR_OF_LOGS [STARTS]]
set -euo pipefail
cd "$(dirname "$0")/.."
logs=${1:-}
starts=${2:-500}
cornerfix=${CORNERFIX:-build/release/bin/cornerfix}
if [[ ! -x $cornerfix ]]; then
  cmake --preset release && cmake --build --preset release --target cornerfix
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

ask() {  # NAME LOG ARGUMENT...
  nice -n 10 "$cornerfix" evaluate "${@:2}" --single-scan --starts "$starts" --out "$work/$1.json" \
    >/dev/null
}

split_of() {
  case $1 in
    freiburg_079 | aces) echo 0.7 ;;
    fhw | csail) echo 0.4 ;;
    freiburg_campus) echo 0.6 ;;
    *) echo 0.5 ;;
  esac
}

willow=tests/data/willow_full_0.05.yaml
nice -n 10 "$cornerfix" simulate "$willow" "$work/willow.jsonl.gz" --length 600 --step 0.3 \
  --seed 5 --fov 360 --beams 360 --range-max 10 --noise 0.05 >/dev/null
ask willow_10m "$work/willow.jsonl.gz" --map-grid "$willow"
for log in ${logs:+"$logs"/*.jsonl.gz}; do
  name=$(basename "$log" .jsonl.gz)
  ask "$name" "$log" --split "$(split_of "$name")"
done

/usr/bin/python3 - "$work" <<'PYTHON'
import json, pathlib, sys

print("| log | mapped scans | right | 95 % interval | right, and heading within 5 deg "
      "| error p50 / p95 m | error p50 / p95 deg | accepted right | accepted wrong "
      "| unmapped scans | accepted wrong there |")
print("|---|" + "---|" * 10)
for path in sorted(pathlib.Path(sys.argv[1]).glob("*.json")):
    s = json.loads(path.read_text())["summary"]
    m, o = s["mapped"], s["outside"]
    low, high = m["top1_right_interval"]
    share = m["top1_right"] / max(1, m["scans"])
    numbers = lambda e: " / ".join("-" if e[k] is None else f"{e[k]:.3f}" for k in ("p50", "p95"))
    print(f"| {path.stem} | {m['scans']} | {share:.3f} | {low:.3f} to {high:.3f} "
          f"| {m['top1_right_heading'] / max(1, m['scans']):.3f} | {numbers(s['error_m'])} "
          f"| {numbers(s['error_deg'])} | {m['accepted_right']} | {m['accepted_wrong']} "
          f"| {o['scans']} | {o['accepted_wrong']} |")
PYTHON
