#pragma once

/// \file
/// Owner of the moving front's arrays, and how the host begins it.

#include <cstddef>
#include <cstdint>

#include "backend/backend.h"
#include "types/angles.h"
#include "types/front.h"
#include "types/indicator_field.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The angle at `p` with the outward normal `n`, counter-clockwise from the direction of `from` to
/// that of `to` in the tangent plane: 0 to 2 pi.
inline float angle_between(const Vec3& p, const Vec3& n, const Vec3& from, const Vec3& to) {
  Vec3 a = from - p, b = to - p;
  a = a - dot(a, n) * n;
  b = b - dot(b, n) * n;
  return positive_angle(dot(a, b), dot(n, cross(a, b)));
}

class Front {
 public:
  /// Empty. \param field  whose cells the front uses; the host reads its table of bricks.
  Front(Backend& backend, const FieldView& field);

  const FrontCounts& counts() const { return counts_; }

  /// The arrays as the next pass takes them. What the host has added is there.
  FrontView view();

  // --- What the host adds, and reads. --------------------------------------------------------

  /// Brings everything to the host's memory, where the functions below work, until the next pass.
  void bring_to_host();

  /// Makes room for that many more at once.
  void reserve(std::size_t vertices, std::size_t triangles, std::size_t corners);

  std::uint32_t add_vertex(const Vec3& position, const Vec3& normal, float size);
  std::uint32_t add_corner(std::uint32_t vertex);
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void link(std::uint32_t from, std::uint32_t to);

  /// After expand_choose: takes its counts and its list, and makes room for what the chosen corners
  /// may add.
  void begin_round();

 private:
  Backend& backend_;
  FieldView field_;
  FrontCounts counts_;
  bool counts_changed_ = true;   ///< by the host
  std::size_t most_listed_ = 0;  ///< corners in the list, at most
  Buffer<FrontCounts> shared_counts_;
  Buffer<FrontVertex> vertices_;
  Buffer<FrontCorner> corners_;
  Buffer<std::uint32_t> triangles_, listed_, alive_, chosen_;
  Buffer<Proposal> proposals_;
  Buffer<FrontStart> starts_;
  Buffer<std::uint64_t> claims_;
  Buffer<std::uint32_t> edge_at_, vertex_at_;
};

}  // namespace vasamesh
