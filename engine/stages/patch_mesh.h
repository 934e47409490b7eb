#pragma once

/// \file
/// A part of a triangle surface as half-edges in flat arrays, and the three operations of
/// remeshing on it: collapse, split, flip. None of them changes the topology of the surface that
/// the part was taken from.
///
/// Half-edge 4 t + i runs from corner i of triangle t to the next one. A vertex is `whole` when all
/// of its triangles in the surface are in the part; others lie on the cut and stay where they are.
///
/// Botsch, Kobbelt: A remeshing approach to multiresolution modeling, 2004; the link condition:
/// Dey, Edelsbrunner, Guha, Nekhayev: Topology preserving edge contraction, 1999.

#include <array>
#include <cstdint>
#include <vector>

#include "types/fans.h"

namespace vasamesh {

class Backend;

class PatchMesh {
 public:
  /// The vertices of a triangle, counter-clockwise from outside.
  using Corners = std::array<std::uint32_t, 3>;

  static constexpr std::uint32_t kNone = 0xffffffffu;
  static constexpr int kLeastLoop = 6;  ///< edges that a collapse leaves in a loop of border edges
  static constexpr int kLeastFan = 4;   ///< triangles that a collapse leaves round an inner vertex

  std::vector<SurfacePoint> points;

  /// \param corners  three vertices a triangle; each edge in at most two triangles, in opposite
  ///                 directions.
  /// \param whole  one a vertex.
  void build(std::vector<SurfacePoint> given, const std::vector<std::uint32_t>& corners,
             std::vector<std::uint8_t> whole);

  /// Whom take_turn() asks; nobody if null.
  void set_backend(const Backend* backend) { backend_ = backend; }

  /// Loops over the part call it once a turn, of a microsecond or some hundred: parts of many small
  /// shells are large. Now and then it is a checkpoint of the backend.
  void take_turn() const {
    if (++turns_ % kTurns == 0) ask_backend();
  }

  /// Lets no operation change the vertices on borders: they are not whole any more.
  void hold_border();

  std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(points.size()); }
  std::uint32_t half_edge_end() const { return static_cast<std::uint32_t>(origin_.size()); }

  static std::uint32_t next(std::uint32_t h) { return (h & 3) == 2 ? h - 2 : h + 1; }
  static std::uint32_t previous(std::uint32_t h) { return (h & 3) == 0 ? h + 2 : h - 1; }

  /// False for half-edges of triangles that are gone and for every fourth index.
  bool is_edge(std::uint32_t h) const { return origin_[h] != kNone; }
  std::uint32_t origin(std::uint32_t h) const { return origin_[h]; }
  std::uint32_t target(std::uint32_t h) const { return origin_[next(h)]; }
  std::uint32_t apex(std::uint32_t h) const { return origin_[previous(h)]; }
  std::uint32_t twin(std::uint32_t h) const { return twin_[h]; }
  /// Of its triangle, from its origin on.
  Corners corners(std::uint32_t h) const { return {origin(h), target(h), apex(h)}; }

  bool is_there(std::uint32_t v) const { return edge_[v] != kNone; }
  bool is_whole(std::uint32_t v) const { return whole_[v] != 0; }
  /// Whether a whole vertex lies on a border of the surface.
  bool is_border(std::uint32_t v) const { return twin_[edge_[v]] == kNone; }
  /// Whole, and on no border: all round it are triangles of the part.
  bool is_inner(std::uint32_t v) const { return is_whole(v) && !is_border(v); }

  /// visit(h) for the half-edges out of a whole vertex, counter-clockwise; on a border from the
  /// border half-edge on.
  template <class Visit>
  void for_each_out(std::uint32_t v, const Visit& visit) const {
    const std::uint32_t first = edge_[v];
    std::uint32_t h = first;
    do {
      visit(h);
      h = twin_[previous(h)];
    } while (h != first && h != kNone);
  }

  /// Whether test(h) holds for all of these; none is tested after one for which it does not.
  template <class Test>
  bool all_out(std::uint32_t v, const Test& test) const {
    const std::uint32_t first = edge_[v];
    std::uint32_t h = first;
    do {
      if (!test(h)) return false;
      h = twin_[previous(h)];
    } while (h != first && h != kNone);
    return true;
  }

  /// Triangles round a whole vertex.
  int fan_size(std::uint32_t v) const;

  /// Whether the whole vertices `from` and `to` are joined by an edge.
  bool are_joined(std::uint32_t from, std::uint32_t to) const;

  /// Whether `gone`, an end of the edge h, may be merged into the other end `kept` without a change
  /// of topology: both whole; the link condition; a border vertex only along its border, whose loop
  /// keeps kLeastLoop edges. Inner vertices keep kLeastFan triangles: three have angles of 120
  /// degrees where the surface is flat, and a shell would end as a tetrahedron.
  bool may_collapse(std::uint32_t h, std::uint32_t gone, std::uint32_t kept);

  /// Merges. \pre may_collapse(h, gone, kept).
  void collapse(std::uint32_t h, std::uint32_t gone, std::uint32_t kept);

  /// A new vertex on the edge h. \return its index.
  std::uint32_t split(std::uint32_t h, const SurfacePoint& point);

  /// Whether the edge h may be turned: all four corners whole, and the new edge is not there yet.
  bool may_flip(std::uint32_t h) const;

  /// Turns the edge h, so that it joins the apexes of its two triangles.
  void flip(std::uint32_t h);

 private:
  static constexpr std::uint32_t kTurns = 16;

  void ask_backend() const;
  void link(std::uint32_t a, std::uint32_t b);
  void set_edge(std::uint32_t v, std::uint32_t h);
  void remove_triangle(std::uint32_t h);
  bool loop_is_short(std::uint32_t border) const;
  bool may_lose_triangle(std::uint32_t v) const;

  std::vector<std::uint32_t> origin_, twin_;
  std::vector<std::uint32_t> edge_;  // a vertex: a half-edge out of it; kNone when gone
  std::vector<std::uint8_t> whole_;
  std::vector<std::uint32_t> mark_;
  std::uint32_t stamp_ = 0;
  const Backend* backend_ = nullptr;
  mutable std::uint32_t turns_ = 0;
};

}  // namespace vasamesh
