#!/usr/bin/env bash
# Pictures into docs/images/: three real surfaces, each as a whole and its thinnest vessel, and places
# from close by with their triangles, of scans whose licences allow it and of phantoms.
#
#   perf/pictures.sh DATA_FOLDER [BUILD_FOLDER]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
data=${1:?usage: perf/pictures.sh DATA_FOLDER [BUILD_FOLDER]}
build=${2:-build/release}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# surface NAME: that of the scan NAME or, where there is none, of the phantom, made once; its file.
surface() {
  local volume=$data/$1.nii.gz file=$scratch/$1.ply
  if [[ ! -e $file ]]; then
    if [[ ! -e $volume ]]; then
      volume=$scratch/$1.nii.gz
      "$build/vasamesh" phantom "$1" -o "$volume" >&2
    fi
    "$build/vasamesh" convert "$volume" --label any -o "$file" --quiet
  fi
  printf '%s\n' "$file"
}

# draw NAME PICTURE VIEW [OPTIONS]: VIEW is the direction to the eye, in one word.
draw() {
  local file
  file=$(surface "$1")
  # shellcheck disable=SC2086
  "$build/vasamesh_picture" "$file" "docs/images/$2.png" --size 900x700 --view $3 "${@:4}"
}

# whole NAME VIEW X Y Z RADIUS: all of it, and the ball to look at closely, mm.
whole() {
  draw "$1" "$1" "$2"
  draw "$1" "${1}_close" "$2" --zoom-to "${@:3}"
}

# triangles NAME PICTURE VIEW X Y Z RADIUS: the ball with its triangles' edges.
triangles() {
  draw "$1" "$2" "$3" --edges --zoom-to "${@:4}"
}

mkdir -p docs/images
whole pulmonary_arteries "0 -1 0" -39.7 -81.3 -749.9 12
whole airways "0 -1 0" 81 -128 -309 7
whole hepatic_veins "0 -1 0" 112.9 175 -345 9
triangles hepatic_veins bifurcation "0.13 0.85 -0.5" 82.4 158.7 -264 6
triangles aneurysm aneurysm "0.3 -0.5 1" 0 2 0 11
triangles pulmonary_arteries thin_tip "-0.77 0.19 0.61" 60.2 -193.3 -615.6 3
triangles two_tubes touching_vessels "0.7 0.15 1" 0 0 0 6
