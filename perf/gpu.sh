#!/usr/bin/env bash
# Everything that is to be known of a machine's OpenCL devices, in one go: builds, tests every pass
# and the whole pipeline on them, tunes the kernels, compares the bytes with oneTBB's, measures.
#
#   perf/gpu.sh [FOLDER]    results go to FOLDER, perf/results/gpu by default
#
# Needs what bootstrap.sh installs and a driver of OpenCL 1.2 or later; where there is no GPU it runs
# on what there is. VASAMESH_DEVICE chooses a device for the bytes' comparison.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build=build/release
results=${1:-perf/results/gpu}
program=$build/vasamesh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$results"

section() {
  printf '\n== %s\n' "$1"
}

# Bytes of both backends, by input.
compare_bytes() {
  local name volume
  for name in y_branch tree two_tubes cerebral; do
    volume=$work/$name.nii.gz
    "$program" phantom "$name" -o "$volume" >/dev/null
    for backend in tbb opencl; do
      "$program" convert "$volume" -o "$work/$backend.ply" --backend "$backend" --quiet
    done
    if cmp -s "$work/tbb.ply" "$work/opencl.ply"; then
      printf '%-12s same bytes\n' "$name"
    else
      printf '%-12s DIFFERENT\n' "$name"
      "$program" check "$work/opencl.ply" --reference "$work/tbb.ply" || true
    fi
  done
}

everything() {
  section build
  ./bootstrap.sh build | tail -n 1
  section devices
  "$program" devices
  section tests
  ctest --test-dir "$build" -R 'opencl|OpenCl|Backends' --output-on-failure | tail -n 5 || true
  section tuning
  "$program" tune
  section bytes
  compare_bytes
  section bench
  perf/backends.py --program "$program" -o "$results/backends"
  sed -n '/^## cerebral/,/^## y_branch/p' "$results/backends.md"
}

everything 2>&1 | tee "$results/log.txt"
