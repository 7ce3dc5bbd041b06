#!/usr/bin/env bash
# Repeats the paper's experiments, puts Cornerfix beside its rivals on the same work, and writes docs/results.md.
#   scripts/bench.sh [--quick] [--robots N] [--data DIR] [--out DIR]
#   --quick   a few robots, scans and trials instead of many: under five minutes
#   --robots  how many are switched on in a building: 50, or 4 when quick. With 50 the run takes hours
#   --data    folder with logs/ and maps/ of recorded drives and floor maps; ../shared/data when it is there
#   --out     where the report goes; docs by default
# Work is done by single-threaded programs, as many at once as there are cores; times are processor time. Times are worth
# something only on a machine that does nothing else.
set -euo pipefail

usage() { echo "usage: $0 [--quick] [--robots N] [--data DIR] [--out DIR]" >&2; exit 2; }
mode=full robots='' data='' out=''
while [[ $# -gt 0 ]]; do
  case "$1" in
    --quick) mode=quick; shift ;;
    --robots) [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || usage; robots=$2; shift 2 ;;
    --data) [[ $# -ge 2 ]] || usage; data=$(realpath -m "$2"); shift 2 ;;
    --out) [[ $# -ge 2 ]] || usage; out=$(realpath -m "$2"); shift 2 ;;
    *) usage ;;
  esac
done
[[ -z $data || -d $data ]] || { echo "$0: no folder $data" >&2; exit 2; }
cd "$(dirname "$0")/.."
[[ -n $data || ! -d ../shared/data ]] || data=$(realpath ../shared/data)
out=${out:-docs}
began=$SECONDS

scripts/install_dependencies.sh bench
cmake --preset release -DCORNERFIX_BUILD_RIVALS=ON >/dev/null
cmake --build --preset release --target cornerfix_bench
bench=$PWD/build/release/bin/cornerfix-bench
built=$SECONDS

results=$PWD/build/bench-results
rm -rf "$results"
mkdir -p "$results"

if [[ $mode == quick ]]; then
  seeds=20 trials=10 largest=30000 worlds=3 starts=4 tracked=1 many=10 asked=10 standing=40 interleaved=4 lengths="--mapping-length 500 --asking-length 120"
else
  seeds=200 trials=100 largest=300000 worlds=40 starts=50 tracked=3 many=100 asked=40 standing=200 interleaved=20 lengths=""
fi

starts=${robots:-$starts}

# A name, then how to come by the building; those whose files are not there are left out.
buildings() {
  local logs=$data/logs maps=$data/maps
  if [[ -n $data && $mode == full ]]; then
    simulated museum "$maps/deutsches_museum_0.11.yaml"
    simulated stata "$maps/stata_basement.yaml"
    simulated changed_office "$maps/strands_tsc_y3.yaml" "$maps/strands_tsc_y4.yaml"
    recorded aces "$logs/aces.jsonl.gz" 0.7
    recorded csail "$logs/csail.jsonl.gz" 0.4
    recorded freiburg_079 "$logs/freiburg_079.jsonl.gz" 0.7
    recorded fhw "$logs/fhw.jsonl.gz" 0.4
  fi
  [[ -z $data ]] || recorded intel "$logs/intel.jsonl.gz" 0.5
  echo "willow --floor-map tests/data/willow_full_0.05.yaml $lengths"
}
recorded() {  # NAME LOG SPLIT
  if [[ -f $2 ]]; then echo "$1 --log $2 --split $3"; else echo "left out, not there: $2" >&2; fi
}
simulated() {  # NAME MAP [INSIDE]
  if [[ -f $2 && -f ${3:-$2} ]]; then
    echo "$1 --floor-map $2 ${3:+--inside $3}"
  else
    echo "left out, not there: $2 ${3:-}" >&2
  fi
}

# An option with the files of all buildings but one.
others() {  # OPTION SUFFIX FILE
  local files
  files=$(find "$data" -name "*$2" ! -path "$3" | LC_ALL=C sort | paste -sd,)
  [[ -z $files ]] || echo "$1 $files"
}
# A line a program; the long ones first.
work() {
  buildings | while read -r name kind file options; do
    [[ $kind == --log ]] || continue
    echo "maps --name $name $kind $file $options $(others --logs .jsonl.gz "$file") $(others --floor-maps .yaml -) --maps $many --starts $asked"
  done
  while read -r name source; do
    echo "robots --name $name $source --starts $starts"
  done < <(buildings)
  buildings | while read -r name kind file options; do
    [[ $kind != --log ]] || options=--even-odd
    echo "tracking --name $name $kind $file $options --starts $tracked"
  done
  # Whether the rivals reach what was measured of their originals.
  buildings | while read -r name kind file options; do
    [[ $kind == --log && ( $name == intel || $name == freiburg_079 ) ]] || continue
    echo "robots --name ${name}_standing $kind $file --split 0.5 --methods cartographer_full --starts $standing --way 0 --time 0"
    echo "robots --name ${name}_even_odd $kind $file --even-odd --methods amcl,mrpt --starts $interleaved"
  done
  echo "matching --trials $trials --largest $largest"
  echo "worlds --worlds $worlds"
  echo "corners --seeds $seeds"
}

describe_run() {
  echo "key,value"
  echo "machine,$(lscpu | sed -n 's/^Model name: *//p' | head -1 | tr ',' ' ')"
  echo "cores,$(nproc)"
  echo "memory_gib,$(awk '/MemTotal/ { printf "%.0f", $2 / 1048576 }' /proc/meminfo)"
  echo "system,$(. /etc/os-release && echo "$PRETTY_NAME")"
  echo "compiler,$(c++ --version | head -1 | tr ',' ' ')"
  echo "commit,$(git rev-parse --short HEAD 2>/dev/null || echo unknown)$(git diff --quiet HEAD 2>/dev/null || echo ' with changes')"
  echo "date,$(date -u +%Y-%m-%d)"
  echo "load,$(cut -d' ' -f1 /proc/loadavg)"
  echo "mode,$mode"
  echo "settings,seeds $seeds; trials $trials; worlds $worlds; robots among $many maps $asked; checks of rivals $standing standing and $interleaved with every other scan; robots a building $starts"
}

describe_run >"$results/run.csv"
buildings 2>&1 >/dev/null | sort -u
work 2>/dev/null | xargs -P "$(nproc)" -I {} sh -c "$bench {} --out $results"
echo "run_seconds,$((SECONDS - built))" >>"$results/run.csv"

/usr/bin/python3 scripts/bench_report.py "$results" "$out"
echo "$out/results.md: $((SECONDS - began)) s, $((built - began)) s of it to build"
