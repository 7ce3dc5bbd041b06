#!/usr/bin/env bash
# Builds Cornerfix, maps a real building in simulation, and lets a robot that was switched on at an unknown place find
# itself in it. Each step names its view of the page, and the browser opens the first one. The page stays open until
# Ctrl-C.
#   scripts/demo.sh --once   ends by itself: exit code 0 when the robot's last pose is within 0.3 m and 3 degrees
set -euo pipefail
cd "$(dirname "$0")/.."

case "${1:-}" in
  "") pace=(--rate 2 --track 20); once=false ;;
  --once) pace=(--track 10); once=true ;;
  *) echo "usage: $0 [--once]" >&2; exit 2 ;;
esac

scripts/install_dependencies.sh build
cmake --preset release >/dev/null
cmake --build --preset release --target cornerfix
PATH=$PWD/build/release/bin:$PATH
floor=$PWD/tests/data/willow_full_0.05.yaml

work=$(mktemp -d)
cd "$work"
server=
trap 'if [[ -n $server ]]; then kill "$server" 2>/dev/null && wait "$server" || true; fi; cd /; rm -rf "$work"' EXIT
trap 'exit 130' INT TERM

show() {  # show TEXT FRAGMENT
  echo "== $1"
  echo "   the page: $url/$2"
}

exec {ready}< <(exec cornerfix serve --db demo.db --port 0 --recorded-answers 300 2>server.log)
server=$!
read -r line <&"$ready" || { cat server.log >&2; exit 1; }
url=${line##* }

show "The service runs. Someone drives a lidar through the Willow Garage building with known poses" ""
if ! $once && [[ -n ${DISPLAY:-} ]] && command -v xdg-open >/dev/null; then xdg-open "$url" >/dev/null 2>&1 || true; fi
cornerfix simulate "$floor" mapping.jsonl.gz --seed 1 --length 600 --step 0.3
cornerfix map build willow mapping.jsonl.gz --server "$url"

show "The map is built" "#map=willow&tab=maps"
show "A robot is switched on somewhere and people walk about: watch it" "#map=willow"
cornerfix simulate "$floor" robot.jsonl.gz --seed 2 --length 60 --people 3
cornerfix replay robot.jsonl.gz --map willow --server "$url" --robot demo --keep-session "${pace[@]}" |
  tee replay.txt

session=$(curl -fsS "$url/v1/sessions" | sed -nE 's/.*"id":"([^"]+)".*/\1/p')
show "The robot is localized; step back to its first answer" "#map=willow&session=$session&answer=0"
$once || { echo "== The page stays at $url until Ctrl-C"; wait "$server"; }

# The last of the lines "... error 0.03 m, 0.2 deg".
read -r metres degrees < <(sed -nE 's/.*error ([0-9.]+) m, ([0-9.]+) deg.*/\1 \2/p' replay.txt | tail -n 1)
echo "== The robot's last pose is $metres m and $degrees deg off"
awk -v m="$metres" -v d="$degrees" 'BEGIN { exit !(m <= 0.3 && d <= 3) }'
