#!/usr/bin/env bash
# Learns the weights of evidence and the decision again, from recorded and simulated drives with reference poses, and says
# how well they hold in buildings left out. Usage: scripts/calibrate.sh DIR_OF_LOGS DIR_OF_MAPS [STARTS]
set -euo pipefail
cd "$(dirname "$0")/.."
logs=${1:?usage: scripts/calibrate.sh DIR_OF_LOGS DIR_OF_MAPS [STARTS]}
maps=${2:?usage: scripts/calibrate.sh DIR_OF_LOGS DIR_OF_MAPS [STARTS]}
starts=${3:-50}
scripts/install_dependencies.sh calibrate
cmake --preset release
cmake --build --preset release --target cornerfix
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cornerfix() { build/release/bin/cornerfix "$@" >/dev/null; }
sample() { cornerfix evaluate "$@" --samples "$work/samples.csv"; }  # LOG [FLAG...]

echo "recorded drives, as they are and mirrored"
while read -r log split batch; do
  for part in "--starts $starts" "--starts $((starts * 3 / 10)) --mirror"; do
    # shellcheck disable=SC2086  # flags are words
    sample "$logs/$log.jsonl.gz" --split "$split" --batch "$batch" $part
  done
done <<EOF
intel 0.25 5
intel 0.5 5
freiburg_079 0.4 5
freiburg_079 0.7 5
fhw 0.4 1
aces 0.4 5
aces 0.7 5
csail 0.2 5
csail 0.4 5
csail 0.7 5
EOF

echo "recorded drives in the maps of other buildings"
buildings="intel freiburg_079 fhw aces csail"
for asked in $buildings; do
  for mapped in $buildings; do
    [[ $asked == "$mapped" ]] && continue
    sample "$logs/$asked.jsonl.gz" --elsewhere "$logs/$mapped.jsonl.gz" --starts $((starts / 6))
  done
done

echo "simulated drives, fine and coarse lidars, with people and boxes, in a building that has changed since"
while read -r building map inside; do
  cornerfix simulate "$maps/$map.yaml" "$work/map.jsonl.gz" --length 900 --step 0.3 --seed 1
  seed=2
  for lidar in "--fov 270 --beams 1081 --range-max 30" "--fov 180 --beams 181 --range-max 8"; do
    for guests in "" "--people 4 --boxes 30"; do
      # shellcheck disable=SC2086
      cornerfix simulate "$maps/$map.yaml" "$work/drive.jsonl.gz" --length 250 --step 0.1 --seed $((seed++)) \
        --name "$building" --inside "$maps/$inside.yaml" $lidar $guests
      sample "$work/drive.jsonl.gz" --map-log "$work/map.jsonl.gz" --starts $((starts / 3))
    done
  done
done <<EOF
willow willow_full_0.05 willow_full_0.05
tsc strands_tsc_y3 strands_tsc_y3
tsc strands_tsc_y3 strands_tsc_y4
stata stata_basement stata_basement
museum deutsches_museum_0.11 deutsches_museum_0.11
EOF
/usr/bin/python3 scripts/calibrate.py "$work/samples.csv"
