#include "stages/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "stages/bricks.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

/// Nodes along each axis round a face centre that may change their label.
std::array<int, 3> free_radius(const Scale& scale, float limit) {
  std::array<int, 3> radius;
  for (std::size_t i = 0; i < 3; ++i)
    radius[i] = std::clamp(static_cast<int>(kDistanceShare * limit / (0.5f * scale[i])), 1, 3);
  return radius;
}

/// Bricks of 4 x 4 x 4 voxels that could hold free nodes or neighbours of them: those within two
/// voxels of an octant that holds outer boundary voxels.
std::vector<BrickCoord> candidate_bricks(Backend& backend, const PointCloud& points) {
  std::vector<BrickCoord> coords(points.bricks.count);
  std::vector<std::uint8_t> octants(points.bricks.count);
  backend.download<BrickCoord>(points.bricks.coords.view(), coords);
  backend.download<std::uint8_t>(points.octants.view(), octants);
  std::vector<BrickCoord> fine;
  for (std::size_t i = 0; i < coords.size(); ++i)
    for (int octant = 0; octant < 8; ++octant)
      if (octants[i] >> octant & 1)
        fine.push_back({2 * coords[i].x + (octant & 1), 2 * coords[i].y + (octant >> 1 & 1),
                        2 * coords[i].z + (octant >> 2)});
  const std::vector<std::uint8_t> all(fine.size(), 0xff);
  return dilate_by_octants(backend, fine, all);
}

std::vector<BrickCoord> used_bricks(Backend& backend, const BitView& object,
                                    const std::vector<BrickCoord>& candidates,
                                    const std::array<int, 3>& radius) {
  Buffer<BrickCoord> coords(backend, candidates.size());
  backend.upload<BrickCoord>(coords.view(), candidates);
  Buffer<std::uint8_t> used(backend, candidates.size());
  backend.lattice_mark(object, {candidates.size(), coords.view(), {}}, radius, used.view());
  std::vector<std::uint8_t> flags(candidates.size());
  backend.download<std::uint8_t>(used.view(), flags);
  std::vector<BrickCoord> kept;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (flags[i]) kept.push_back(candidates[i]);
  return kept;
}

}  // namespace

float distance_limit(const Scale& scale, double kernel_width) {
  const auto [least, most] = std::minmax_element(scale.begin(), scale.end());
  const auto wider = static_cast<float>(std::max(kernel_width / Parameters{}.kernel_width, 1.0));
  return wider * std::max(*least, 0.55f * *most);
}

Lattice build_lattice(Backend& backend, const BitVolume& object, const PointCloud& points,
                      const Scale& scale, const Octree& octree, const Parameters& parameters) {
  Lattice lattice;
  lattice.limit = distance_limit(scale, parameters.kernel_width);
  const std::array<int, 3> radius = free_radius(scale, lattice.limit);
  const std::vector<BrickCoord> coords =
      used_bricks(backend, object.view(), candidate_bricks(backend, points), radius);
  const std::size_t nodes = coords.size() * kBrickCells;
  if (nodes > std::numeric_limits<std::uint32_t>::max())  // lists of nodes hold their numbers
    throw Error(ErrorCode::refused,
                "the surface needs more than 2^32 lattice nodes: convert a part of the volume");
  lattice.bricks = make_bricks(backend, coords);
  lattice.state = Buffer<std::uint8_t>(backend, nodes);
  lattice.values = Buffer<float>(backend, nodes);
  backend.lattice_label(object.view(), static_cast<int>(parameters.connectivity),
                        lattice.bricks.view(), radius, lattice.state.view());

  std::vector<BrickCoord> parents = coords;
  for (BrickCoord& c : parents) c = {c.x >> 1, c.y >> 1, c.z >> 1};
  const OctreeLevel& regular = octree.at_exponent(0);
  const auto in_regular = neighbours_in(backend, parents, regular.coords);
  const std::span<const BrickCoord> refined_coords =
      octree.has_refined() ? std::span<const BrickCoord>(octree.at_exponent(-1).coords)
                           : std::span<const BrickCoord>();
  const auto in_refined = neighbours_in(backend, coords, refined_coords);
  const View<const float> refined =
      octree.has_refined() ? octree.at_exponent(-1).solution.view() : View<const float>();
  backend.lattice_sample(lattice.bricks.view(), in_regular.view(), regular.solution.view(),
                         in_refined.view(), refined, lattice.values.view());
  return lattice;
}

}  // namespace vasamesh
