#!/usr/bin/env bash
# Learns the acceptance model again, from recorded and simulated runs with reference poses, and
# reports how well it holds in buildings and in domains left out.
# Usage: scripts/calibrate.sh DIR_OF_LOGS DIR_OF_MAPS [STARTS]
set -euo pipefail
cd "$(dirname "$0")/.."
usage="usage: scripts/calibrate.sh DIR_OF_LOGS DIR_OF_MAPS [STARTS]"
logs=${1:?$usage}
maps=${2:?$usage}
starts=${3:-50}
scripts/install_dependencies.sh calibrate
cmake --preset release
cmake --build --preset release --target cornerfix
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/samples"

cornerfix() { build/release/bin/cornerfix "$@" >/dev/null; }
sample() { cornerfix evaluate "${@:2}" --samples "$work/samples/$1.csv"; }  # DOMAIN LOG [FLAG...]
batch_of() { case $1 in fhw | freiburg_campus) echo 1 ;; *) echo 5 ;; esac; }

echo "recorded runs, as they are and mirrored"
while read -r log splits; do
  for split in $splits; do
    flags="--split $split --batch $(batch_of "$log")"
    # shellcheck disable=SC2086  # flags are words
    sample "$log" "$logs/$log.jsonl.gz" $flags --starts "$starts"
    # shellcheck disable=SC2086
    sample "$log" "$logs/$log.jsonl.gz" $flags --starts $((starts * 3 / 10)) --mirror
  done
done <<EOF
intel 0.25 0.5
freiburg_079 0.4 0.7
fhw 0.4
aces 0.4 0.7
csail 0.2 0.4 0.7
freiburg_campus 0.3 0.6
EOF

echo "recorded runs with few scans and no odometry"
while read -r log split stride; do
  sample sparse "$logs/$log.jsonl.gz" --split "$split" --stride "$stride" --batch 1 --no-odom \
    --starts "$starts"
done <<EOF
intel 0.5 30
freiburg_079 0.6 12
aces 0.6 20
csail 0.5 5
EOF

echo "recorded runs in the maps of other buildings"
buildings="intel freiburg_079 fhw aces csail freiburg_campus"
for asked in $buildings; do
  for mapped in $buildings; do
    [[ $asked == "$mapped" ]] && continue
    sample "$asked" "$logs/$asked.jsonl.gz" --batch "$(batch_of "$asked")" \
      --elsewhere "$logs/$mapped.jsonl.gz" --starts $((starts / 6))
  done
done

# DOMAIN BUILDING MAP INSIDE LIDAR: runs with and without people and boxes in the building as INSIDE
# has it, asked in the occupancy map MAP.
seed=2
sample_building() {
  for guests in "" "--people 4 --boxes 30"; do
    # shellcheck disable=SC2086
    cornerfix simulate "$3" "$work/run.jsonl.gz" --length 250 --step 0.1 --seed $((seed++)) \
      --name "$2" --inside "$4" $5 $guests
    sample "$1" "$work/run.jsonl.gz" --map-grid "$3" --starts $((starts / 3))
  done
}
fine="--fov 270 --beams 1081 --range-max 30"
coarse="--fov 180 --beams 181 --range-max 8"
round="--fov 360 --beams 360 --range-max 12 --noise 0.03"
short="--fov 240 --beams 120 --range-max 4"

echo "simulated runs in occupancy maps, one of them of a building that has changed since"
while read -r building map inside; do
  for lidar in "$fine" "$coarse" "$round" "$short"; do
    sample_building simulated "$building" "$maps/$map.yaml" "$maps/$inside.yaml" "$lidar"
  done
done <<EOF
willow willow_full_0.05 willow_full_0.05
tsc strands_tsc_y3 strands_tsc_y3
tsc strands_tsc_y3 strands_tsc_y4
stata stata_basement stata_basement
museum deutsches_museum_0.11 deutsches_museum_0.11
EOF

echo "generated scenes whose stock, cars or furniture changed since"
for kind in warehouse yard corridors home hall office glass; do
  for layout in 1 2 3; do
    for change in 1 2; do
      cornerfix scene "$kind" "$work/scene$change" --layout-seed "$layout" --change-seed "$change"
    done
    for lidar in "$fine" "$round"; do
      sample_building "$kind" "$kind$layout" "$work/scene1.yaml" "$work/scene2.yaml" "$lidar"
    done
  done
done
/usr/bin/python3 scripts/calibrate.py "$work"/samples/*.csv
