#!/usr/bin/env bash
# Times the micro benchmarks of another revision and of the working tree in turn, and prints the ratios.
#   scripts/compare.sh REV [FILTER] [ROUNDS]
# The two take turns, so that what else the machine does meets both alike; each ratio is the median over the rounds, with
# the lowest and the highest beside it. Below 1 the working tree is faster.
set -euo pipefail
cd "$(dirname "$0")/.."

rev=${1:?usage: scripts/compare.sh REV [FILTER] [ROUNDS]}
filter=${2:-.}
rounds=${3:-5}
git rev-parse --verify --quiet "$rev^{commit}" >/dev/null || { echo "$0: no revision $rev" >&2; exit 2; }
scripts/install_dependencies.sh build

work=$(mktemp -d)
trap 'git worktree remove --force "$work/tree" 2>/dev/null || true; rm -rf "$work"' EXIT
git worktree add --quiet --detach "$work/tree" "$rev"

build() {  # SOURCES
  (cd "$1" && cmake --preset release >/dev/null && cmake --build --preset release --target cornerfix_micro_bench)
}
build "$work/tree"
build .

measure() {  # SOURCES OUT
  "$1/build/release/bin/cornerfix_micro_bench" --benchmark_filter="$filter" --benchmark_format=csv >"$2" 2>/dev/null
}
for round in $(seq "$rounds"); do
  echo "round $round of $rounds" >&2
  measure "$work/tree" "$work/before_$round.csv"
  measure . "$work/after_$round.csv"
done

/usr/bin/python3 - "$work" "$rounds" "$rev" <<'PYTHON'
import csv, statistics, sys

work, rounds, rev = sys.argv[1], int(sys.argv[2]), sys.argv[3]


def read(path):
    """Processor time of each benchmark in ns; the file begins with lines about the machine."""
    with open(path) as file:
        lines = file.read().splitlines()
    header = next(i for i, line in enumerate(lines) if line.startswith("name,"))
    unit = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}
    return {row["name"]: float(row["cpu_time"]) * unit[row["time_unit"]] for row in csv.DictReader(lines[header:])}


pairs = [(read(f"{work}/before_{i}.csv"), read(f"{work}/after_{i}.csv")) for i in range(1, rounds + 1)]
names = [name for name in pairs[0][1] if name in pairs[0][0]]
if not names:
    sys.exit("no benchmark that both revisions have")
width = max(map(len, names))
print(f"{'':{width}} {rev[:12] + ' ns':>16} {'now ns':>14} {'ratio':>7}  lowest - highest")
for name in names:
    ratios = [after[name] / before[name] for before, after in pairs]
    before = statistics.median(p[0][name] for p in pairs)
    after = statistics.median(p[1][name] for p in pairs)
    print(f"{name:{width}} {before:16,.0f} {after:14,.0f} {statistics.median(ratios):7.3f}  {min(ratios):.3f} - {max(ratios):.3f}")
PYTHON
