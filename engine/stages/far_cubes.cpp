#include "stages/far_cubes.h"

#include <algorithm>
#include <cmath>

#include "types/marching_cube.h"

namespace vasamesh {

namespace {

constexpr int kFaces = 12;

/// The entry of make_far_parts() for the faces i > j, or i > j > k.
int pair_at(int i, int j) { return i * (i - 1) / 2 + j; }
int triple_at(int i, int j, int k) {
  return pair_at(kFaces, 0) + i * (i - 1) * (i - 2) / 6 + pair_at(j, k);
}

float length_of(const Scale& scale, const std::array<float, 3>& nodes) {
  const float dx = 0.5f * scale[0] * nodes[0], dy = 0.5f * scale[1] * nodes[1],
              dz = 0.5f * scale[2] * nodes[2];
  return std::sqrt((dx * dx + dy * dy) + dz * dz);
}

std::array<float, 3> nodes_of(int face) {
  const NodeOffset o = kCubeFaces[static_cast<std::size_t>(face)];
  return {static_cast<float>(o.x), static_cast<float>(o.y), static_cast<float>(o.z)};
}

FarPart make_part(const Scale& scale, int count, const std::array<std::int32_t, 3>& faces) {
  FarPart part{count, faces, {}, 0, {}};
  for (int k = 0; k < count; ++k)
    for (std::size_t a = 0; a < 3; ++a)
      part.middle[a] += nodes_of(faces[static_cast<std::size_t>(k)])[a];
  for (float& middle : part.middle) middle /= static_cast<float>(count);
  for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
    std::array<float, 3> away = nodes_of(faces[k]);
    for (std::size_t a = 0; a < 3; ++a) away[a] -= part.middle[a];
    part.from_face[k] = length_of(scale, away);
  }
  part.from_corner = length_of(scale, part.middle);
  return part;
}

std::uint8_t state_of(int voxels, NodeOffset o) {
  const auto object = [&](int x, int y, int z) {
    return voxels >> ((x > 0) + 2 * (y > 0) + 4 * (z > 0)) & 1;
  };
  if (o.x && o.y && o.z) return object(o.x, o.y, o.z) ? kSolid : 0;
  const bool below = object(o.x ? o.x : -1, o.y ? o.y : -1, o.z ? o.z : -1);
  const bool above = object(o.x ? o.x : 1, o.y ? o.y : 1, o.z ? o.z : 1);
  return below != above ? kFaceCentre : 0;
}

void add_parts(std::array<int, kFaces> polygon, int size, std::vector<std::uint16_t>& parts) {
  std::sort(polygon.begin(), polygon.begin() + size);
  const auto corner = [&](int i) { return polygon[static_cast<std::size_t>(i)]; };
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < i; ++j) {
      parts.push_back(static_cast<std::uint16_t>(pair_at(corner(i), corner(j))));
      for (int k = 0; k < j; ++k)
        parts.push_back(static_cast<std::uint16_t>(triple_at(corner(i), corner(j), corner(k))));
    }
}

FarCubes make_far_cubes() {
  FarCubes all{};
  for (int voxels = 0; voxels < 256; ++voxels) {
    FarCube& cube = all.cubes[static_cast<std::size_t>(voxels)];
    cube.first_part = static_cast<std::int32_t>(all.parts.size());
    cube.first_side = static_cast<std::int32_t>(all.sides.size());
    const MarchingCube marching([&](NodeOffset o) { return state_of(voxels, o); });
    marching.for_each_polygon([&](const std::array<int, kFaces>& polygon, int size) {
      add_parts(polygon, size, all.parts);
    });
    for (std::size_t s = 0; s < marching.side_count; ++s)
      all.sides.push_back(
          static_cast<std::uint16_t>(marching.sides[s][0] + 16 * marching.sides[s][1]));
    cube.last_part = static_cast<std::int32_t>(all.parts.size());
    cube.last_side = static_cast<std::int32_t>(all.sides.size());
  }
  return all;
}

}  // namespace

std::vector<FarPart> make_far_parts(const Scale& scale) {
  std::vector<FarPart> parts;
  for (int i = 0; i < kFaces; ++i)
    for (int j = 0; j < i; ++j) parts.push_back(make_part(scale, 2, {i, j, 0}));
  for (int i = 0; i < kFaces; ++i)
    for (int j = 0; j < i; ++j)
      for (int k = 0; k < j; ++k) parts.push_back(make_part(scale, 3, {i, j, k}));
  return parts;
}

const FarCubes& far_cubes() {
  static const FarCubes cubes = make_far_cubes();
  return cubes;
}

}  // namespace vasamesh
