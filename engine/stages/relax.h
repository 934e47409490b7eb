#pragma once

/// \file
/// Smoothing and moves towards equal edges of all parts of a surface at once: vertices that lie on
/// the field by passes of the backend, the few others by the host. A vertex sees those of its
/// neighbours that come before it in its part where they have been moved to, as if all were moved
/// one after the other.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "stages/patch_mesh.h"
#include "stages/patch_passes.h"
#include "types/fans.h"

namespace vasamesh {

/// Buffers of the passes, kept from one to the next.
class Relaxer {
 public:
  /// Keeps references. \pre field, sizes and places lie in the host's memory.
  Relaxer(Backend& backend, const RemeshGoal& goal) : backend_(backend), goal_(goal) {}

  /// Moves vertices in their tangent planes to the middle of the triangles round them (weighted by
  /// area over squared size; border vertices along the border), and onto the surface.
  void smooth(std::span<PatchMesh* const> parts, int passes);

  /// Moves inner vertices to where the triangles round them have edges of more equal lengths.
  void equalise(std::span<PatchMesh* const> parts, int passes);

  /// Moves inner vertices on the surface along their normals until the surface lies, on average
  /// over the triangles round each, as far inside of them as outside: a tube keeps the area of its
  /// section. Then `passes` of moves towards equal edges across the normals. Where sheets are near
  /// each other (patch_crowding.h), only where no triangle comes to meet another. All are off the
  /// field then: passes that follow leave them where they are along their normals.
  void fit(std::span<PatchMesh* const> parts, int passes);

 private:
  /// The fans of one part that are to be moved.
  struct Fans {
    std::vector<std::uint32_t> vertex, level_first, ring_first, ring;
  };
  /// The vertices of one part that only the host moves, each with a look at what is near.
  struct Crowd;
  /// Where each part's entries start in the flat arrays.
  struct Starts {
    std::vector<std::uint32_t> point, level, fan, ring;
  };

  /// Whether a vertex of a part is to be moved by a pass.
  using Chosen = std::function<bool(std::size_t part, std::uint32_t vertex)>;

  static Fans fans_of(const PatchMesh& part, std::size_t p, const Chosen& chosen);
  void count(std::span<PatchMesh* const> parts, const std::vector<Fans>& fans);
  /// \return whether there is anything for a pass.
  bool load(std::span<PatchMesh* const> parts, const Chosen& chosen);
  void load_fans(const Fans& fans, std::size_t p);
  void load_points(std::span<PatchMesh* const> parts);
  void take_points(std::span<PatchMesh* const> parts);
  void find_gaps();
  std::vector<float> gaps_of(const PatchMesh& part, std::size_t p, const Crowd& crowd) const;
  static void fit_part(PatchMesh& part, const std::vector<float>& gaps, Crowd& crowd);
  FanView view() const;

  Backend& backend_;
  const RemeshGoal& goal_;
  Starts start_;
  Buffer<SurfacePoint> points_;
  Buffer<float> gaps_;  ///< a fan
  Buffer<std::uint32_t> part_level_, level_first_, vertex_, ring_first_, ring_;
};

}  // namespace vasamesh
