#include "stages/hard.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "backend/ranges.h"
#include "stages/adjacency.h"
#include "stages/disjoint_sets.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr float kThin = 0.7f;    // of edge_min: a smaller radius of curvature is hard
constexpr float kRoom = 0.6f;    // of edge_min: no other sheet within this, along the normal
constexpr float kGrowth = 3.0f;  // edge lengths that regions are grown by
constexpr float kBeyond = 3.1f;  // edge lengths: farther than that from any region
constexpr float kFar = 1e6f;
constexpr float kBeside = 1e-3f;      // a distance that is near, but not in a hard cell
constexpr std::uint32_t kIsland = 8;  // cells of the surface that are not left alone
constexpr std::size_t kSampleGrain = 256, kSurfaceGrain = 8192;

/// Whether the function keeps its sign on each side of the surface as far as `reach`.
bool has_room(const FieldView& field, const Vec3& p, const Vec3& normal, float reach) {
  for (const float part : {0.5f, 1.0f}) {
    const FieldSample outside = sample_field(field, p + (part * reach) * normal);
    const FieldSample inside = sample_field(field, p - (part * reach) * normal);
    if ((outside.known && outside.value >= 0) || (inside.known && inside.value <= 0)) return false;
  }
  return true;
}

bool is_hard(const FieldView& field, const SurfaceSamples& samples, const SizeRule& rule,
             std::size_t i) {
  return samples.radius[i] < kThin * rule.edge_min ||
         !has_room(field, samples.position[i], samples.normal[i], kRoom * rule.edge_min);
}

/// The size cell at an offset from another; kNoCell where there is no brick.
constexpr std::uint32_t kNoCell = 0xffffffffu;
std::uint32_t neighbour_cell(const std::int32_t* neighbours, std::uint32_t cell, int dx, int dy,
                             int dz) {
  const int x = static_cast<int>(cell & 3) + dx, y = static_cast<int>(cell >> 2 & 3) + dy;
  const int z = static_cast<int>(cell >> 4 & 3) + dz;
  const std::int32_t brick =
      neighbours[27 * std::size_t{cell >> 6} +
                 static_cast<std::size_t>(brick_neighbour(x >> 2, y >> 2, z >> 2))];
  if (brick == kNoBrick) return kNoCell;
  return 64 * static_cast<std::uint32_t>(brick) +
         static_cast<std::uint32_t>((x & 3) + 4 * (y & 3) + 16 * (z & 3));
}

/// Takes the small rests between regions into them: cells of the surface beyond the growth that
/// hang together in groups too small for a few triangles.
void fill_islands(const IndicatorField& field, const SizeField& sizes, Buffer<float>& distance) {
  const std::vector<std::uint32_t>& cells = sizes.samples.cell;
  const std::int32_t* neighbours = field.neighbours.view().data();
  float* to_hard = distance.view().data();
  std::vector<std::uint32_t> sample_at(distance.size(), kNoCell);
  for (std::uint32_t i = 0; i < cells.size(); ++i)
    if (to_hard[cells[i]] > kGrowth * sizes.sizes.view()[cells[i]]) sample_at[cells[i]] = i;
  DisjointSets groups(cells.size());
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (sample_at[cells[i]] == kNoCell) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint32_t other =
          neighbour_cell(neighbours, cells[i], axis == 0, axis == 1, axis == 2);
      if (other == kNoCell || sample_at[other] == kNoCell) continue;
      groups.unite(sample_at[other], i);
    }
  }
  const std::vector<std::uint32_t> root = std::move(groups).roots();
  std::vector<std::uint32_t> size(cells.size(), 0);
  for (std::uint32_t i = 0; i < cells.size(); ++i) ++size[root[i]];
  for (std::uint32_t i = 0; i < cells.size(); ++i)
    if (sample_at[cells[i]] != kNoCell && size[root[i]] <= kIsland) to_hard[cells[i]] = kBeside;
}

enum Nearness : std::uint8_t { kAway, kNear, kWithin };  ///< of a vertex to a hard cell

/// Which vertices lie within the growth of a hard cell, or in it.
std::vector<std::uint8_t> near_vertices(Backend& backend, const SizeView& distance,
                                        const SizeView& sizes, const TriangleMesh& surface) {
  std::vector<std::uint8_t> near(surface.vertex_count());
  for_each_index(backend, near.size(), kSurfaceGrain, [&](std::size_t v) {
    const Vec3 at = vertex_at(surface, v);
    const float apart = size_at(distance, at);
    near[v] = !(apart > 0) ? kWithin : apart <= kGrowth * size_at(sizes, at) ? kNear : kAway;
  });
  return near;
}

/// The triangles with a flagged vertex.
std::vector<std::uint8_t> triangles_at(Backend& backend, const std::vector<std::uint8_t>& flagged,
                                       const TriangleMesh& surface) {
  std::vector<std::uint8_t> hard(surface.triangle_count());
  for_each_index(backend, hard.size(), kSurfaceGrain, [&](std::size_t t) {
    const std::uint32_t* v = &surface.triangles[3 * t];
    hard[t] = flagged[v[0]] || flagged[v[1]] || flagged[v[2]];
  });
  return hard;
}

/// An unflagged vertex (in the higher half) and one of its neighbours, for each hard triangle with
/// both; sorted.
std::vector<std::uint64_t> spokes_of(Backend& backend, const TriangleMesh& surface,
                                     const std::vector<std::uint8_t>& hard,
                                     const std::vector<std::uint8_t>& flagged) {
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<std::uint64_t>& found) {
    for (std::size_t c = 3 * begin; c < 3 * end; ++c) {
      const std::uint32_t v = surface.triangles[c];
      if (!hard[c / 3] || flagged[v]) continue;
      for (const std::size_t other : {c / 3 * 3 + (c + 1) % 3, c / 3 * 3 + (c + 2) % 3})
        found.push_back(std::uint64_t{v} << 32 | surface.triangles[other]);
    }
  };
  auto spokes = collect<std::uint64_t>(backend, hard.size(), kSurfaceGrain, find);
  std::sort(spokes.begin(), spokes.end());
  return spokes;
}

/// Flags the vertices at which the hard triangles are more than one fan. \return whether any is.
bool widen_pinches(Backend& backend, const TriangleMesh& surface,
                   const std::vector<std::uint8_t>& hard, std::vector<std::uint8_t>& flagged) {
  // A fan has one triangle more than inner edges; a whole star has as many.
  const std::vector<std::uint64_t> spokes = spokes_of(backend, surface, hard, flagged);
  bool any = false;
  for (std::size_t i = 0; i < spokes.size();) {
    const std::uint64_t v = spokes[i] >> 32;
    const std::size_t first = i;
    std::size_t inner = 0;
    for (++i; i < spokes.size() && spokes[i] >> 32 == v; ++i) inner += spokes[i] == spokes[i - 1];
    const std::size_t fans = (i - first) / 2 - inner;
    if (fans < 2) continue;
    flagged[v] = kNear;
    any = true;
  }
  return any;
}

/// Takes off the regions that hold no hard cell: places of another sheet, or islands of a few
/// triangles that the cells of the growth's rim leave.
void drop_islands(Backend& backend, const TriangleMesh& surface,
                  const std::vector<std::uint8_t>& flagged, std::vector<std::uint8_t>& hard) {
  const std::vector<std::uint32_t> root = connect_vertices(backend, surface, hard);
  std::vector<std::uint8_t> kept(root.size(), 0);
  for (std::uint32_t v = 0; v < root.size(); ++v)
    if (flagged[v] == kWithin) kept[root[v]] = 1;
  for_each_index(backend, hard.size(), kSurfaceGrain, [&](std::size_t t) {
    if (hard[t]) hard[t] = kept[root[surface.triangles[3 * t]]];
  });
}

}  // namespace

std::vector<std::uint8_t> find_hard_regions(Backend& backend, const IndicatorField& field,
                                            const SizeField& sizes, const SizeRule& rule,
                                            const TriangleMesh& surface) {
  const FieldView view = field.view();
  const SurfaceSamples& samples = sizes.samples;
  Buffer<float> distance(backend, sizes.sizes.size());
  float* to_hard = distance.view().data();
  std::fill_n(to_hard, distance.size(), kBeyond * rule.edge_max);
  for_each_index(backend, samples.count(), kSampleGrain, [&](std::size_t i) {
    if (is_hard(view, samples, rule, i)) to_hard[samples.cell[i]] = 0;
  });
  grow_limited(backend, field, 1.0f, distance);
  fill_islands(field, sizes, distance);

  std::vector<std::uint8_t> at_vertex =
      near_vertices(backend, {view, distance.view(), kFar}, sizes.view(field), surface);
  std::vector<std::uint8_t> hard = choose_triangles(backend, surface, at_vertex);
  drop_islands(backend, surface, at_vertex, hard);
  return hard;
}

std::vector<std::uint8_t> choose_triangles(Backend& backend, const TriangleMesh& surface,
                                           std::vector<std::uint8_t>& flagged) {
  std::vector<std::uint8_t> chosen = triangles_at(backend, flagged, surface);
  while (widen_pinches(backend, surface, chosen, flagged))
    chosen = triangles_at(backend, flagged, surface);
  return chosen;
}

}  // namespace vasamesh
