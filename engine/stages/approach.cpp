#include "stages/approach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "stages/distance.h"
#include "stages/patch_blocks.h"
#include "stages/patch_clearance.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"
#include "types/box.h"
#include "types/mesh_vertex.h"
#include "types/segment.h"

namespace vasamesh {

namespace {

constexpr int kRounds = 6, kReturns = 2;
constexpr int kCarefulRounds = 3, kCarefulReturns = 1;  // without angles below 20 degrees
constexpr float kAim = 0.93f;  // of the farthest distance: where a move is to end
constexpr float kLongestMove = 0.5f, kReach = 0.4f;  // voxel lengths: of a vertex, of a projection
constexpr float kAtVertex = 0.65f;   // weight from which the nearest point counts as a vertex
constexpr float kLeastSplit = 0.6f;  // of the size: shorter edges are not split
constexpr float kSame = 0.01f;       // voxel lengths between equal distances

struct FarPoint {
  Vec3 position;
  float distance = 0;
};

/// The point of a triangle nearest to another, as weights of its corners.
struct Foot {
  std::uint32_t triangle = PatchMesh::kNone;
  std::array<float, 3> weight{};
  float squared = 0;  ///< distance
};

/// Inside the prism over the triangle the foot of the perpendicular, elsewhere on its border.
Foot foot_on(const Vec3& p, const std::array<Vec3, 3>& corner) {
  Foot foot;
  const Vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
  const float area = squared_norm(normal);
  bool inside = area > 0;
  for (std::size_t i = 0; i < 3 && inside; ++i) {
    const Vec3& a = corner[(i + 1) % 3];
    foot.weight[i] = dot(cross(corner[(i + 2) % 3] - a, p - a), normal) / area;
    inside = foot.weight[i] >= 0;
  }
  if (inside) {
    const float height = dot(normal, p - corner[0]);
    foot.squared = height * height / area;
    return foot;
  }
  foot.squared = -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &a = corner[i], &b = corner[(i + 1) % 3];
    const float s = nearest_along(p - a, b - a);
    const float squared = squared_norm((a + s * (b - a)) - p);
    if (foot.squared >= 0 && squared >= foot.squared) continue;
    foot.squared = squared;
    foot.weight = {};
    foot.weight[i] = 1 - s;
    foot.weight[(i + 1) % 3] = s;
  }
  return foot;
}

class Approach {
 public:
  /// \param least  squared sine: of the angles that are made, unless they were smaller before.
  Approach(PatchMesh& mesh, const RemeshGoal& goal, float farthest, float least)
      : mesh_(mesh), goal_(goal), farthest_(farthest), least_(least), clearance_(mesh) {}

  /// One step of the part's vertex at `from`, if it has it, towards a point.
  void draw_vertex(const Vec3& from, const Vec3& to) {
    for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
      if (mesh_.points[v].position == from && mesh_.is_there(v)) move(v, to, 0);
  }

  /// One step towards a point, if the part has the triangle that is nearest to it.
  void draw_to(const FarPoint& point) {
    const Vec3& p = point.position;
    const Foot foot = nearest(p, point.distance + kSame);
    if (foot.triangle == PatchMesh::kNone || foot.squared <= farthest_ * farthest_) return;
    std::array<std::uint32_t, 3> order = {0, 1, 2};
    std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
      return foot.weight[i] != foot.weight[j] ? foot.weight[i] > foot.weight[j] : i < j;
    });
    const std::uint32_t first = 4 * foot.triangle;
    const std::array<std::uint32_t, 3> corner = {mesh_.origin(first + order[0]),
                                                 mesh_.origin(first + order[1]),
                                                 mesh_.origin(first + order[2])};
    const std::uint32_t edge = PatchMesh::next(first + order[2]);
    if (foot.weight[order[0]] >= kAtVertex && move(corner[0], p, kAim * farthest_)) return;
    if (split(edge, p)) return;
    for (const std::uint32_t v : corner)
      if (move(v, p, kAim * farthest_)) return;
    for (std::uint32_t h = first; h < first + 3; ++h)
      if (h != edge && split(h, p)) return;
  }

 private:
  Foot nearest(const Vec3& p, float reach) const;
  bool split(std::uint32_t h, const Vec3& p);
  bool move(std::uint32_t v, const Vec3& p, float rest);

  /// A part of the way from `from` to where `rest` is left to p.
  static Vec3 towards(const Vec3& from, const Vec3& p, float rest, float part) {
    const float apart = norm(p - from);
    const float step = std::clamp(apart - rest, 0.0f, kLongestMove);
    return apart > 0 ? from + (part * step / apart) * (p - from) : from;
  }

  PatchMesh& mesh_;
  const RemeshGoal& goal_;
  float farthest_;
  float least_;
  Clearance clearance_;
};

/// The nearest point of the part, none beyond `reach`.
Foot Approach::nearest(const Vec3& p, float reach) const {
  Foot best;
  best.squared = reach * reach;
  for (std::uint32_t h = 0; h < mesh_.half_edge_end(); h += 4) {
    if (!mesh_.is_edge(h)) continue;
    const std::array<Vec3, 3> corner = {mesh_.points[mesh_.origin(h)].position,
                                        mesh_.points[mesh_.origin(h + 1)].position,
                                        mesh_.points[mesh_.origin(h + 2)].position};
    const float edge =
        std::max(squared_norm(corner[1] - corner[0]), squared_norm(corner[2] - corner[0]));
    if (squared_norm(p - corner[0]) > 2 * (best.squared + edge)) continue;
    Foot foot = foot_on(p, corner);
    if (foot.squared > best.squared) continue;
    best = foot;
    best.triangle = h / 4;
  }
  return best;
}

/// A new vertex on the edge: on the surface, where that is near enough to p, else towards p.
bool Approach::split(std::uint32_t h, const Vec3& p) {
  const std::uint32_t t = mesh_.twin(h), v = mesh_.origin(h), w = mesh_.target(h);
  if (t == PatchMesh::kNone || (!mesh_.is_whole(v) && !mesh_.is_whole(w))) return false;
  const SurfacePoint a = mesh_.points[v], b = mesh_.points[w];
  if (relative_length(a, b) < kLeastSplit * kLeastSplit) return false;
  const SurfacePoint middle = {0.5f * (a.position + b.position), normalised(a.normal + b.normal),
                               0.5f * (a.size + b.size), std::max(a.drift, b.drift), false};
  SurfacePoint place = middle;
  put_onto_surface(goal_, kReach, place);
  if (squared_norm(p - place.position) > farthest_ * farthest_)
    place.position = towards(place.position, p, kAim * farthest_, 1);
  for (const std::uint32_t g : {h, t}) {
    const SurfacePoint& from = mesh_.points[mesh_.origin(g)];
    const SurfacePoint& to = mesh_.points[mesh_.target(g)];
    const SurfacePoint& apex = mesh_.points[mesh_.apex(g)];
    if (triangle_quality(from, place, apex, kLeastFacingInRepair) < least_ ||
        triangle_quality(place, to, apex, kLeastFacingInRepair) < least_)
      return false;
  }
  const std::uint32_t m = mesh_.split(h, middle);
  mesh_.for_each_out(m, [&](std::uint32_t g) { clearance_.take_up(mesh_, g); });
  return clearance_.move_if_clear(mesh_, m, place);
}

/// Moves v towards p, up to `rest` from it; at a spur's tip, where no normal is of use, whatever
/// its triangles face.
bool Approach::move(std::uint32_t v, const Vec3& p, float rest) {
  if (!mesh_.is_inner(v)) return false;
  const SurfacePoint old = mesh_.points[v];
  for (const float least_facing : {kLeastFacingInRepair, -1.0f})
    for (const float part : {1.0f, 0.5f}) {
      SurfacePoint moved = old;
      moved.position = towards(old.position, p, rest, part);
      moved.on_field = false;
      bool good = true;
      mesh_.for_each_out(v, [&](std::uint32_t h) {
        const SurfacePoint &b = mesh_.points[mesh_.target(h)], &c = mesh_.points[mesh_.apex(h)];
        const float limit = std::min(least_, least_squared_sine(old, b, c));
        good = good && (least_facing > 0 ? may_replace(old, moved, b, c, limit, least_facing)
                                         : least_squared_sine(moved, b, c) >= limit);
      });
      if (good && clearance_.move_if_clear(mesh_, v, moved)) return true;
    }
  return false;
}

std::vector<FarPoint> far_points(Backend& backend, std::span<const Vec3> points, float farthest,
                                 const TriangleMesh& mesh) {
  const std::vector<float> distances =
      distances_to(backend, points, mesh, build_triangle_tree(backend, mesh));
  std::vector<FarPoint> found;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (distances[i] > farthest) found.push_back({points[i], distances[i]});
  return found;
}

Box box_round(const PatchMesh& part) {
  Box box;
  for (const SurfacePoint& point : part.points) box.take_in(point.position);
  return box;
}

/// The points within reach of the part.
std::vector<FarPoint> points_of(const std::vector<FarPoint>& points, const PatchMesh& part) {
  const Box box = box_round(part);
  std::vector<FarPoint> found;
  for (const FarPoint& point : points)
    if (box.holds(point.position, point.distance)) found.push_back(point);
  return found;
}

/// Balls that hold what is nearest to the points.
Places places_of(const std::vector<FarPoint>& points) {
  std::vector<CarefulPlace> places;
  for (const FarPoint& point : points) places.push_back({point.position, point.distance, 1});
  return Places(places);
}

}  // namespace

TriangleMesh approach(Backend& backend, const FieldView& field, const SizeView& sizes,
                      std::span<const Vec3> points, float farthest, TriangleMesh mesh) {
  if (mesh.triangles.empty()) return mesh;
  std::vector<FarPoint> far = far_points(backend, points, farthest, mesh);
  for (int round = 0; round < kRounds && !far.empty(); ++round) {
    const float least = round < kCarefulRounds ? kSquaredSine20 : kSquaredSine10;
    const Places places = places_of(far);
    const RemeshGoal goal = {field, sizes, &places, true};
    WorkingSurface surface = make_working_surface(backend, goal, mesh);
    for_each_block(backend, {block_side(sizes), 0.15f * static_cast<float>(round)}, surface,
                   [&](PatchMesh& part) {
                     const std::vector<FarPoint> own = points_of(far, part);
                     if (own.empty()) return;
                     Approach work(part, goal, farthest, least);
                     for (const FarPoint& point : own) work.draw_to(point);
                   });
    mesh = make_mesh(backend, surface);
    far = far_points(backend, points, farthest, mesh);
  }
  return mesh;
}

namespace {

/// A vertex, and where it belongs.
struct StrayVertex {
  Vec3 from, to;
};

/// The vertices farther from another surface than they may be; of those near the places, if any.
std::vector<StrayVertex> stray_vertices(Backend& backend, const TriangleMesh& origin,
                                        const TriangleTree& tree, float farthest,
                                        const Places& places, const TriangleMesh& mesh) {
  std::vector<Vec3> vertices;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    if (const Vec3 p = vertex_at(mesh, v); places.empty() || places.hold(p, Places::kMargin))
      vertices.push_back(p);
  const NearestTriangles nearest = nearest_triangles(backend, vertices, origin, tree, farthest);
  std::vector<StrayVertex> strays;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    if (!(nearest.distances[v] > farthest)) continue;
    std::array<Vec3, 3> corner;
    for (std::size_t i = 0; i < 3; ++i)
      corner[i] = vertex_at(origin, origin.triangles[3 * nearest.triangles[v] + i]);
    const Foot foot = foot_on(vertices[v], corner);
    strays.push_back({vertices[v], foot.weight[0] * corner[0] + foot.weight[1] * corner[1] +
                                       foot.weight[2] * corner[2]});
  }
  return strays;
}

Places places_of(const std::vector<StrayVertex>& strays) {
  std::vector<CarefulPlace> places;
  for (const StrayVertex& stray : strays)
    places.push_back({stray.from, norm(stray.to - stray.from), 1});
  return Places(places);
}

}  // namespace

TriangleMesh bring_back(Backend& backend, const FieldView& field, const SizeView& sizes,
                        const TriangleMesh& origin, const TriangleTree& tree, float farthest,
                        TriangleMesh mesh, const Places& within) {
  Places places = within;
  for (int round = 0; round < kReturns; ++round) {
    const std::vector<StrayVertex> strays =
        stray_vertices(backend, origin, tree, farthest, places, mesh);
    if (strays.empty()) break;
    const float least = round < kCarefulReturns ? kSquaredSine20 : kSquaredSine10;
    places = places_of(strays);
    const RemeshGoal goal = {field, sizes, &places, true};
    WorkingSurface surface = make_working_surface(backend, goal, mesh);
    for_each_block(backend, {block_side(sizes), 0.3f * static_cast<float>(round)}, surface,
                   [&](PatchMesh& part) {
                     const Box box = box_round(part);
                     std::optional<Approach> work;
                     for (const StrayVertex& stray : strays) {
                       if (!box.holds(stray.from)) continue;
                       if (!work) work.emplace(part, goal, farthest, least);
                       work->draw_vertex(stray.from, stray.to);
                     }
                   });
    mesh = make_mesh(backend, surface);
  }
  return mesh;
}

}  // namespace vasamesh
