#!/usr/bin/env bash
# Pictures of three real surfaces, each as a whole and its thinnest vessel, into docs/images/.
#
#   perf/pictures.sh DATA_FOLDER [BUILD_FOLDER]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
data=${1:?usage: perf/pictures.sh DATA_FOLDER [BUILD_FOLDER]}
build=${2:-build/release}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# draw NAME VIEW X Y Z RADIUS: the ball to look at closely, mm.
draw() {
  local name=$1 view=$2 surface=$scratch/$1.ply
  shift 2
  "$build/vasamesh" convert "$data/$name.nii.gz" --label any -o "$surface" --quiet
  # shellcheck disable=SC2086
  "$build/vasamesh_picture" "$surface" "docs/images/$name.png" --size 900x700 --view $view
  # shellcheck disable=SC2086
  "$build/vasamesh_picture" "$surface" "docs/images/${name}_close.png" --size 900x700 --view $view \
    --zoom-to "$@"
}

mkdir -p docs/images
draw pulmonary_arteries "0 -1 0" -39.7 -81.3 -749.9 12
draw airways "0 -1 0" 81 -128 -309 7
draw hepatic_veins "0 -1 0" 112.9 175 -345 9
