#!/usr/bin/env bash
# The honesty run: is a `localized` answer ever wrong? Asks recorded and simulated runs in their own
# map, in the maps of other buildings, mirrored, after changes, among 100 maps and with faulty
# odometry, and writes one table per domain.
#   scripts/honesty.sh [--quick] [--jobs N] [--plans DIR] DIR_OF_LOGS DIR_OF_MAPS [OUT]
# DIR_OF_LOGS holds *.jsonl.gz with reference poses. DIR_OF_MAPS and --plans hold map_server yamls
# of occupancy maps and of drawn plans. OUT (default build/honesty) gets results/*.json,
# explained/*/* of the starts whose first answer was wrong, and honesty.md.
# A run that was stopped goes on where it was: parts whose result exists are skipped. Remove OUT to
# measure another version. --quick asks about 300 starts. docs/evaluation.md describes the figures.
set -euo pipefail
cd "$(dirname "$0")/.."
usage="usage: scripts/honesty.sh [--quick] [--jobs N] [--plans DIR] DIR_OF_LOGS DIR_OF_MAPS [OUT]"

quick=false
jobs=$(nproc)
plans=
while [[ ${1:-} == --* ]]; do
  case $1 in
    --quick) quick=true ;;
    --jobs) jobs=${2:?$usage} && shift ;;
    --plans) plans=${2:?$usage} && shift ;;
    *) echo "$usage" >&2 && exit 2 ;;
  esac
  shift
done
logs=${1:?$usage}
maps=${2:?$usage}
out=${3:-build/honesty}
mkdir -p "$out/runs" "$out/results"
export CORNERFIX=${CORNERFIX:-build/release/bin/cornerfix} OUT=$out
if [[ ! -x $CORNERFIX ]]; then
  cmake --preset release && cmake --build --preset release --target cornerfix
fi

# --- what is asked: tasks in the order in which they run, "what|target|arguments"
made=$out/made.txt asked=$out/asked.txt
: >"$made"
: >"$asked"
makes() { echo "$1 $2 ${*:3}" >>"$made"; }                 # scene|simulate TARGET ARGUMENT...
asks() { echo "$1 $2 ${*:3} --threads 1" >>"$asked"; }     # DOMAIN NAME ARGUMENT...

# count FULL QUICK
count() { if $quick; then echo "$2"; else echo "$1"; fi; }

batch_of() { case $1 in fhw | freiburg_campus) echo 1 ;; *) echo 5 ;; esac; }
splits_of() {
  case $1 in
    intel) count "0.3 0.5" 0.5 ;;
    freiburg_079 | aces | csail) count "0.4 0.7" 0.7 ;;
    fhw) echo 0.4 ;;
    freiburg_campus) echo 0.6 ;;
    *) echo 0.5 ;;
  esac
}
names_in() { find -L "$1" -maxdepth 1 -name "*$2" -printf '%f\n' | sed "s/${2//./\\.}\$//" | sort; }

log_names=$(names_in "$logs" .jsonl.gz)
map_names=$(names_in "$maps" .yaml)

ask_logs() {
  local log other split file n
  local -a all
  mapfile -t all <<<"$log_names"
  for n in "${!all[@]}"; do
    log=${all[n]}
    file="$logs/$log.jsonl.gz --batch $(batch_of "$log")"
    for split in $(splits_of "$log"); do
      asks own-map "$log-$split" "$file" --split "$split" --starts "$(count 300 8)" --track 10
    done
    asks mirrored "$log" "$file" --split "$split" --mirror --starts "$(count 100 4)" --way 10
    for other in "${all[@]}"; do
      [[ $log == "$other" ]] && continue
      $quick && [[ $other != "${all[(n + 1) % ${#all[@]}]}" ]] && continue
      asks elsewhere "$log-in-$other" "$file" --elsewhere "$logs/$other.jsonl.gz" \
        --starts "$(count 80 6)" --way 10
    done
    ask_with_faults "$log" "$file --split $split" 60
    ask_among_maps "$log" "$file --split $split"
  done
}

# NAME ARGUMENTS STARTS
ask_with_faults() {
  for fault in zero hang two_publishers wrong_heading jump; do
    $quick && [[ $1 != freiburg_079 && $1 != willow* ]] && continue
    # shellcheck disable=SC2086  # arguments are words
    asks "fault-$fault" "$1" $2 --odom-fault "$fault" --track 30 --starts "$(count "$3" 4)"
  done
}

among=
# NAME ARGUMENTS
ask_among_maps() {
  $quick && [[ $1 != fhw ]] && return
  # shellcheck disable=SC2086
  asks many-maps "$1" $2 --any-map $among --starts "$(count 100 6)"
}

# Scenes of their own layouts, so that no place is asked among itself.
prepare_many_maps() {
  local kind layout
  for kind in office corridors home hall glass; do
    for layout in $(seq 101 "$(count 120 102)"); do
      local scene=$OUT/runs/among-$kind-$layout
      makes scene "$scene.yaml" "$kind" "$scene" --layout-seed "$layout"
      among+=" $scene.yaml"
    done
  done
}

# Field of view [deg], beams, longest range [m].
lidars=("270 1081 30" "360 360 12" "180 181 8")

# NAME MAP INSIDE DOMAIN STARTS: a run maps the building as MAP has it, another asks in it as INSIDE
# has it; and the occupancy map alone is asked. The ways are free in both.
ask_building() {
  local name=$1 map=$2 inside=$3 domain=$4 starts=$5 n ask
  local mapping=$OUT/runs/$name-map.jsonl.gz
  makes simulate "$mapping" "$inside" "$mapping" --inside "$map" --length "$(count 700 300)" \
    --step 0.3 --seed 1
  for n in "${!lidars[@]}"; do
    $quick && ((n != 1)) && continue
    # shellcheck disable=SC2206  # words
    local lidar=(${lidars[n]})
    ask=$OUT/runs/$name-ask$n.jsonl.gz
    makes simulate "$ask" "$map" "$ask" --inside "$inside" --length 300 --step 0.1 \
      --seed $((n + 2)) --people 3 --boxes 10 --noise 0.03 \
      --fov "${lidar[0]}" --beams "${lidar[1]}" --range-max "${lidar[2]}"
    asks "$domain" "$name-run-$n" "$ask" --map-log "$mapping" --starts "$starts" --track 10
    asks "$domain-grid" "$name-grid-$n" "$ask" --map-grid "$map" --starts "$starts" --track 10
  done
}

ask_maps() {
  local name
  for name in $map_names; do
    ask_building "$name" "$maps/$name.yaml" "$maps/$name.yaml" occupancy-map "$(count 80 6)"
  done
  if [[ -f $maps/strands_tsc_y3.yaml && -f $maps/strands_tsc_y4.yaml ]]; then
    ask_building tsc-changed "$maps/strands_tsc_y3.yaml" "$maps/strands_tsc_y4.yaml" \
      changed-building "$(count 100 6)"
  fi
  if [[ -f $maps/willow_full_0.05.yaml ]]; then
    local willow=willow_full_0.05
    ask_with_faults willow "$OUT/runs/$willow-ask1.jsonl.gz --map-grid $maps/$willow.yaml" 100
  fi
}

ask_plans() {
  local name n
  [[ -n $plans ]] || return 0
  for name in $(names_in "$plans" .yaml); do
    for n in $(seq "$(count 3 1)"); do
      local run=$OUT/runs/plan-$name-$n.jsonl.gz
      makes simulate "$run" "$plans/$name.yaml" "$run" --seed $((n + 4)) --length 150 \
        --fov 360 --beams 360 --range-max 12 \
        --noise 0.03 --people $((2 * n - 2)) --boxes $((10 * n - 10))
      asks drawn-plan "$name-$n" "$run" --map-grid "$plans/$name.yaml" \
        --starts "$(count 80 6)" --track 10
    done
  done
}

ask_scenes() {
  local kind layout
  for kind in warehouse yard corridors office home hall glass; do
    local layouts=4
    [[ $kind == warehouse || $kind == yard ]] && layouts=10
    for layout in $(seq "$(count $layouts 1)"); do
      local scene=$OUT/runs/$kind-$layout
      for change in 1 2; do
        makes scene "$scene-$change.yaml" "$kind" "$scene-$change" --layout-seed "$layout" \
          --change-seed "$change"
      done
      ask_building "$kind-$layout" "$scene-1.yaml" "$scene-2.yaml" "scene-$kind" "$(count 20 4)"
    done
    $quick || ask_other_layouts "$kind" "$layouts"
  done
}

# KIND LAYOUTS: the run in each layout asks in the maps of the next three.
ask_other_layouts() {
  local layout next
  for layout in $(seq "$2"); do
    for next in 1 2 3; do
      local other=$(((layout + next - 1) % $2 + 1))
      asks "elsewhere-$1" "$layout-in-$other" "$OUT/runs/$1-$layout-ask0.jsonl.gz" \
        --elsewhere "$OUT/runs/$1-$other-map.jsonl.gz" --starts 20 --way 20
    done
  done
}

prepare_many_maps
ask_logs
ask_maps
ask_plans
ask_scenes

# --- running: each part writes its result under another name first, so that what exists is whole
# shellcheck disable=SC2317  # xargs calls it
make_one() {  # WHAT TARGET ARGUMENT...
  [[ -e $2 ]] && return
  if [[ $1 == scene ]]; then
    nice -n 10 "$CORNERFIX" "$1" "${@:3}" >/dev/null || return 1
    return
  fi
  local part=$OUT/runs/part-$BASHPID.jsonl.gz
  nice -n 10 "$CORNERFIX" "$1" "$3" "$part" "${@:5}" --name "$(basename "$2" .jsonl.gz)" \
    >/dev/null 2>"$part.log" && mv "$part" "$2" && rm "$part.log" && return
  echo "failed: cornerfix $*" >&2
  cat "$part.log" >&2
  return 1
}

# shellcheck disable=SC2317  # xargs calls it
ask_one() {  # DOMAIN NAME ARGUMENT...
  local result=$OUT/results/$1.$2.json begin=$SECONDS
  if [[ ! -e $result ]]; then
    local part=$OUT/results/$1.$2.part
    nice -n 10 "$CORNERFIX" evaluate "${@:3}" --out "$part" >/dev/null 2>"$part.log" || {
      echo "failed: cornerfix evaluate ${*:3}" >&2
      tail -3 "$part.log" >&2
      return 1
    }
    mv "$part" "$result"
    rm "$part.log"
  fi
  local finished
  finished=$(find "$OUT/results" -name '*.json' | wc -l)
  printf '[%s/%s] %-22s %-36s %s s\n' "$finished" "$PARTS" "$1" "$2" $((SECONDS - begin)) >&2
}

# shellcheck disable=SC2317  # xargs calls it
explain_one() {  # DOMAIN NAME START
  local folder=$OUT/explained/$1.$2 words
  [[ -e $folder/start_$3.json ]] && return
  read -ra words < <(grep -F "$1 $2 " "$OUT/asked.txt")
  nice -n 10 "$CORNERFIX" evaluate "${words[@]:2}" --explain "$3" --out "$folder" >/dev/null 2>&1
}
export -f make_one ask_one explain_one
PARTS=$(wc -l <"$asked")
export PARTS

echo "making $(wc -l <"$made") scenes and runs" >&2
failed=0
each() { xargs -r -P "$jobs" -L 1 bash -c "$1 \"\$@\"" _ || failed=1; }
each make_one < <(grep '^scene' "$made")
each make_one < <(grep '^simulate' "$made")
echo "asking $PARTS parts" >&2
each ask_one <"$asked"
/usr/bin/python3 scripts/honesty.py --first-wrong "$out/results" >"$out/wrong.txt"
echo "explaining $(wc -l <"$out/wrong.txt") starts" >&2
each explain_one <"$out/wrong.txt"
/usr/bin/python3 scripts/honesty.py "$out/results" >"$out/honesty.md"
cat "$out/honesty.md"
exit "$failed"
