#pragma once

/// \file
/// A closed gap's patch brought to the density of the surface round it: long edges split at their
/// middles, which are projected onto the surface; flips towards Delaunay and smoothing round each
/// new vertex. The rim's edges stay, and every new edge ends at a new vertex, so that no edge of
/// the surface, or of another patch, can be met.
///
/// Liepa: Filling holes in meshes, 2003 (refinement by density).

#include <cstdint>
#include <vector>

#include "stages/gap_rules.h"
#include "types/sizes.h"
#include "types/vec3.h"

namespace vasamesh {

/// A patch by itself; triangles are indices of its points.
struct Patch {
  std::vector<Vec3> points;   ///< the corners of the rim first
  std::vector<Vec3> normals;  ///< the surface's outward unit normals
  std::vector<std::uint32_t> triangles;
  std::size_t rim = 0;  ///< how many corners that has
};

/// Workspace; reused from patch to patch.
class PatchRefiner {
 public:
  PatchRefiner(const FieldView& field, const SizeView& sizes) : field_(field), sizes_(sizes) {}

  /// Adds vertices where the sizes ask for them, and where one makes the worst triangle better.
  /// `patch` is a disc; its points beyond the rim may move.
  void run(Patch& patch);

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  void link_triangles();
  void place(std::uint32_t triangle, const std::uint32_t (&corners)[3],
             const std::uint32_t (&twins)[3]);
  float length_ratio(std::uint32_t h) const;
  std::uint32_t longest_edge() const;
  std::uint32_t longest_edge_of(std::uint32_t triangle) const;
  bool insert(std::uint32_t h);
  void split(std::uint32_t h, std::uint32_t vertex);
  void settle(std::uint32_t vertex);
  bool flip_opposite(std::uint32_t vertex);
  bool wants_flip(std::uint32_t h) const;
  void flip(std::uint32_t h);
  bool smooth(std::uint32_t vertex);
  void improve_worst();
  void collect_fan(std::uint32_t vertex);
  float worst_of_fan() const;
  float facing(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  float measure(std::uint32_t triangle) const;
  std::uint32_t worst_triangle() const;
  bool are_joined(std::uint32_t a, std::uint32_t b) const;

  std::uint32_t from(std::uint32_t h) const { return patch_->triangles[h]; }
  std::uint32_t to(std::uint32_t h) const { return patch_->triangles[next(h)]; }
  std::uint32_t apex(std::uint32_t h) const { return patch_->triangles[previous(h)]; }
  static std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static std::uint32_t previous(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

  FieldView field_;
  SizeView sizes_;
  Patch* patch_ = nullptr;
  std::size_t rim_ = 0;
  // Half edge 3 t + i goes from corner i of triangle t to the next.
  std::vector<std::uint32_t> twin_;  ///< kNone on the rim
  std::vector<float> ratio_;         ///< (length / size)^2; 0 on the rim and where not to be split
  std::vector<std::uint32_t> fan_;   ///< half edges that leave a vertex
  std::vector<std::uint32_t> ends_;  ///< for linking: half edges by their lower corner
  Patch saved_patch_;
  std::vector<std::uint32_t> saved_twin_;
  std::vector<float> saved_ratio_;
};

}  // namespace vasamesh
