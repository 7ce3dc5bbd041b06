#!/usr/bin/env bash
# Learns the weights of evidence and the decision again, from recorded drives with reference poses, and says how well they
# hold in buildings left out. Usage: scripts/calibrate.sh DIR_OF_LOGS [STARTS]
set -euo pipefail
cd "$(dirname "$0")/.."
logs=${1:?usage: scripts/calibrate.sh DIR_OF_LOGS [STARTS]}
starts=${2:-40}
scripts/install_dependencies.sh calibrate
cmake --preset release
cmake --build --preset release --target cornerfix
samples=$(mktemp --suffix=.csv)
trap 'rm -f "$samples"' EXIT

sample() {  # LOG SPLIT BATCH STARTS [FLAG...]
  local log=$1 split=$2 batch=$3 count=$4
  shift 4
  build/release/bin/cornerfix evaluate "$logs/$log.jsonl.gz" --split "$split" --batch "$batch" --starts "$count" \
    --samples "$samples" "$@" >/dev/null
}

while read -r log split batch; do
  sample "$log" "$split" "$batch" "$starts"
  sample "$log" "$split" "$batch" $((starts * 3 / 10)) --mirror
done <<EOF
intel 0.5 5
intel 0.3 5
freiburg_079 0.7 5
fhw 0.4 1
aces 0.7 5
csail 0.4 5
csail 0.7 5
EOF
/usr/bin/python3 scripts/calibrate.py "$samples"
