#!/usr/bin/env bash
# From a fresh Debian 12 and a clone to a working program:
#
#   ./bootstrap.sh build   installs what is missing and builds build/release/vasamesh
#   ./bootstrap.sh test    the same, then runs all tests
#   ./bootstrap.sh demo    the same, then makes a vessel tree, converts it and draws it
#
# Works as root and for a user with sudo, again and again; installs nothing that is there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

build=build/release

tools=(g++ cmake ninja-build pkg-config)
libraries=(libinsighttoolkit5-dev libvtk9-dev libtbb-dev ocl-icd-opencl-dev opencl-headers
  pocl-opencl-icd libeigen3-dev libnanoflann-dev libcli11-dev libfmt-dev libspdlog-dev
  nlohmann-json3-dev libcgal-dev libisal-dev)
for_tests=(libgtest-dev libgmock-dev libbenchmark-dev zlib1g-dev oclgrind)
for_pictures=(xvfb libgl1-mesa-dri)
packages=("${tools[@]}" "${libraries[@]}" "${for_tests[@]}" "${for_pictures[@]}")

usage() {
  sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
}

fail() {
  printf 'bootstrap.sh: %s\n' "$1" >&2
  exit 1
}

missing_packages() {
  local package status
  for package in "${packages[@]}"; do
    status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
    [[ $status == installed ]] || printf '%s\n' "$package"
  done
}

# Without a password, or with a person there to type it.
can_sudo() {
  command -v sudo >/dev/null || return 1
  [[ -t 0 ]] || sudo -n true 2>/dev/null
}

install_missing() {
  if ! command -v apt-get >/dev/null; then
    fail "this is no Debian: install what these Debian 12 packages hold, then build with
cmake --preset release && cmake --build --preset release
  ${packages[*]}"
  fi
  local missing as_root=()
  mapfile -t missing < <(missing_packages)
  ((${#missing[@]})) || return 0
  if ((EUID != 0)); then
    if ! can_sudo; then
      fail "packages are missing and only root can install them. As root run:
  apt-get update && apt-get install --no-install-recommends ${missing[*]}"
    fi
    as_root=(sudo)
  fi
  printf 'Installing %s\n' "${missing[*]}"
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -q --no-install-recommends "${missing[@]}" ||
    fail "the installation failed. These packages are needed: ${missing[*]}"
}

# One job a core, but no more than memory allows: a compiler run on ITK or CGAL takes 1.5 GB.
jobs() {
  local cores memory
  cores=$(nproc)
  memory=$(awk '/^MemAvailable:/ {print int($2 / 1572864)}' /proc/meminfo)
  ((memory >= 1)) || memory=1
  printf '%s\n' $((cores < memory ? cores : memory))
}

build() {
  install_missing
  if command -v ccache >/dev/null; then
    export CMAKE_C_COMPILER_LAUNCHER=${CMAKE_C_COMPILER_LAUNCHER-ccache}
    export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER-ccache}
  fi
  cmake --preset release
  cmake --build --preset release -j "$(jobs)"
}

# Runs ctest and repeats, at the very end, what failed, the verdict and the time. What fails is run
# once more, alone, so that its output stands at the end; the verdict is that of the first run.
run_tests() {
  local log=$build/ctest.log code=0 skipped
  ctest --test-dir "$build" --no-tests=error --output-on-failure -j "$(nproc)" 2>&1 | tee "$log" ||
    code=${PIPESTATUS[0]}
  if ((code != 0)); then
    ctest --test-dir "$build" --rerun-failed --output-on-failure 2>&1 |
      sed 's/^/once more: /' || true
  fi
  skipped=$(grep -c '\*\*\*Skipped' "$log" || true)
  printf '\n%s tests skipped\n' "$skipped"
  grep -E '^[0-9]+% tests passed|^Total Test time' "$log" || true
  return "$code"
}

demo() {
  local folder=$build/demo
  mkdir -p "$folder"
  "$build/vasamesh" phantom cerebral -o "$folder/cerebral.nii.gz"
  "$build/vasamesh" convert "$folder/cerebral.nii.gz" -o "$folder/cerebral.vtp" \
    --report "$folder/cerebral.json"
  "$build/vasamesh_picture" "$folder/cerebral.vtp" "$folder/cerebral.png"
  printf '\n'
  printf '%-8s  %s\n' Volume "$folder/cerebral.nii.gz" Surface "$folder/cerebral.vtp" \
    Report "$folder/cerebral.json" Picture "$folder/cerebral.png"
}

(($# == 1)) || { usage >&2; exit 2; }
case $1 in
  build) build ;;
  test) build; run_tests ;;
  demo) build; demo ;;
  -h | --help) usage ;;
  *) usage >&2; exit 2 ;;
esac
