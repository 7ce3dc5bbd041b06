#!/usr/bin/env bash
# Builds with warnings as errors, checks format and style, and runs every test.
set -euo pipefail
cd "$(dirname "$0")/.."

failed=()
step() {
  local name=$1 began=$SECONDS
  shift
  echo "== $name"
  "$@" || failed+=("$name")
  echo "== $name: $((SECONDS - began)) s"
}

check_format() { git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run --Werror; }
# Eight sources at a time, so that their headers are read once: a fifth of the time. Tests are held to the compiler's warnings only.
check_style() {
  local status=0
  cmake -S . -B build/style -G Ninja -DCMAKE_UNITY_BUILD=ON -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DCORNERFIX_BUILD_TESTS=OFF >/dev/null
  cmake --build build/style --target cornerfix_ros_idl_generate >/dev/null  # its headers
  run-clang-tidy -quiet -checks=-bugprone-suspicious-include -extra-arg=-Wno-unknown-warning-option -p build/style "(Unity|$PWD/(core|storage|api|server|evaluation|frames|ros2|clients|cli))/.*" \
    >build/style/clang-tidy.log 2>&1 || status=1
  grep -E '(warning|error):' build/style/clang-tidy.log | sort -u && status=1
  return "$status"
}

scripts/install_dependencies.sh test
cmake --preset ci
step build cmake --build --preset ci
[[ ${#failed[@]} -eq 0 ]] || exit 1
step format check_format
step style check_style

# On a machine that has all of the above no test has a reason to be skipped.
export CORNERFIX_REQUIRE_TOOLS=1
logs=$(dirname "$PWD")/shared/data
[[ -d $logs ]] || echo "no recorded logs at ../shared/data: the tests on them will be skipped"
step tests ctest --preset ci -j "$(nproc)"
[[ ${#failed[@]} -eq 0 ]] || { echo "failed: ${failed[*]}" >&2; exit 1; }
