#!/usr/bin/env bash
# Installs the Debian packages that are missing; does nothing when all are there.
#   scripts/install_dependencies.sh build   to build and run
#   scripts/install_dependencies.sh test    to test and check as well
#   scripts/install_dependencies.sh package to build the Debian package and to test it (scripts/package_test.sh)
#   scripts/install_dependencies.sh fuzz    to build and to fuzz
#   scripts/install_dependencies.sh bench   to build and to compare with the rivals (scripts/bench.sh)
#   scripts/install_dependencies.sh calibrate   to build and to learn the evidence model again
set -euo pipefail

build=(
  g++ cmake ninja-build pkg-config
  libeigen3-dev libceres-dev libopencv-core-dev libopencv-imgproc-dev libpng-dev libyaml-cpp-dev zlib1g-dev
  libbz2-dev liblz4-dev libzstd-dev
  libcpp-httplib-dev nlohmann-json3-dev libsimdjson-dev libpq-dev libsqlite3-dev libsqlitecpp-dev
  libspdlog-dev libcli11-dev prometheus-cpp-dev libgtest-dev libgmock-dev libbenchmark-dev
  libjs-leaflet libjs-chart.js
  cyclonedds-dev cyclonedds-tools
)
test=(
  libfastrtps-dev git ccache clang-format clang-tidy chromium chromium-driver python3-selenium python3-jsonschema python3-yaml
  prometheus curl python3-pip python3-setuptools python3-wheel
  help2man nginx-light openssl postgresql haproxy systemd
  ros-core python3-rospy python3-tf2-ros python3-diagnostic-msgs python3-geometry-msgs python3-nav-msgs
  python3-sensor-msgs python3-std-srvs
)

case "${1:-}" in
  build) wanted=("${build[@]}") ;;
  test) wanted=("${build[@]}" "${test[@]}") ;;
  package) wanted=("${build[@]}" help2man dpkg-dev debootstrap curl) ;;
  fuzz) wanted=("${build[@]}" clang-14 libclang-rt-14-dev) ;;
  bench) wanted=("${build[@]}" git libmrpt-slam-dev libopencv-features2d-dev python3-matplotlib python3-numpy) ;;
  calibrate) wanted=("${build[@]}" python3-numpy python3-scipy) ;;
  *) echo "usage: $0 build|test|package|fuzz|bench|calibrate" >&2; exit 2 ;;
esac

is_installed() { [[ $(dpkg-query -W -f '${Status}' "$1" 2>/dev/null) == "install ok installed" ]]; }

missing=()
for package in "${wanted[@]}"; do
  is_installed "$package" || missing+=("$package")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

as_root=()
if [[ $(id -u) -ne 0 ]]; then
  command -v sudo >/dev/null || { echo "Become root, or install: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "installing ${#missing[@]} Debian packages: ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
