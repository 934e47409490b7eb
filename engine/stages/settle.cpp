#include "stages/settle.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>

#include "backend/ranges.h"
#include "stages/adjacency.h"
#include "stages/approach.h"
#include "stages/far_points.h"
#include "stages/intersect.h"
#include "stages/mesh_parts.h"
#include "stages/patch_blocks.h"
#include "stages/patch_rules.h"
#include "stages/places.h"
#include "stages/remesh.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr float kFarShare = 0.93f;   // of the limit: what of marching cubes is too far
constexpr float kMostShare = 0.97f;  // of the limit: what of the surface is too far from them
constexpr float kNearShare = 0.85f;  // of the limit: how near the surface is brought
constexpr float kStray = 0.4f;       // voxel lengths: of a vertex from the base surface, at most
constexpr float kSpread = 2;         // voxel lengths beyond a place up to which its faults may move
constexpr float kReach = 2;          // beyond the places of a try up to which its work is looked at
constexpr float kCollar = 6;         // beyond that, of the surface that is cut out
// Of the edges in the middle of a place, try by try, and how they grow from there out.
constexpr float kFactors[] = {0.8f, 0.55f, 0.7f,  1,    0.8f, 0.6f, 0.35f, 0.6f,
                              1.3f, 0.25f, 0.8f,  1,    0.5f, 0.7f, 0.9f,  0.9f,
                              0.6f, 0.45f, 0.65f, 1.1f, 0.8f, 0.4f, 0.75f, 0.5f};
constexpr std::size_t kChain = 3, kHalf = 12;  // tries
constexpr float kPart[] = {1, 0.6f};           // of the place's radius, half by half
constexpr int kAgain = 2;  // that a try is brought near again: one move may leave other points far
constexpr std::size_t kSolidShare = 4;  // triangles of marching cubes that are as much work as one
constexpr std::size_t kTogether = 8;    // places that are mended at the same time
constexpr float kMending = 2;           // voxel lengths round a triangle of poor shape
constexpr int kMendingRounds = 3, kEveningPasses = 4, kWideningPasses = 12, kOpeningPasses = 8;
constexpr float kGrowth[] = {1, 1.35f, 1.7f, 2.2f};

/// What is wrong with a surface, and where.
struct Faults {
  std::vector<Vec3> meeting;  ///< where triangles meet that should not
  std::vector<Vec3> far;      ///< points of either that are too far from the other
  std::vector<Vec3> sharp;    ///< triangles with an angle below 10 degrees
  std::vector<Vec3> poor;     ///< and those below 20 degrees

  /// The worst first.
  std::array<std::size_t, 4> counts() const {
    return {meeting.size(), far.size(), sharp.size(), poor.size()};
  }

  /// Those in the places; all, if there are none.
  std::vector<Vec3> within(const Places& places) const {
    std::vector<Vec3> points;
    for (const std::vector<Vec3>* some : {&meeting, &far, &sharp, &poor})
      std::copy_if(some->begin(), some->end(), std::back_inserter(points),
                   [&](const Vec3& p) { return places.empty() || places.hold(p); });
    return points;
  }
};

/// visit(a, b, c) for the corners of all triangles.
template <class Visit>
void for_each_triangle(const TriangleMesh& mesh, const Visit& visit) {
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const std::uint32_t* v = &mesh.triangles[3 * t];
    visit(vertex_at(mesh, v[0]), vertex_at(mesh, v[1]), vertex_at(mesh, v[2]));
  }
}

Vec3 middle_of(const Vec3& a, const Vec3& b, const Vec3& c) { return (1.0f / 3) * ((a + b) + c); }

/// Finds the triangles with angles below 20 degrees.
void find_poor_triangles(const TriangleMesh& mesh, Faults& faults) {
  for_each_triangle(mesh, [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    const float squared_sine =
        least_squared_sine(squared_norm(b - a), squared_norm(c - b), squared_norm(a - c),
                           squared_norm(cross(b - a, c - a)));
    if (squared_sine < kSquaredSine20)
      (squared_sine < kSquaredSine10 ? faults.sharp : faults.poor).push_back(middle_of(a, b, c));
  });
}

/// The middles of the triangles in the places, or of all if there are none, with an edge more than
/// 1.5 times as long as another.
std::vector<Vec3> uneven_triangles(const TriangleMesh& mesh, const Places& within) {
  std::vector<Vec3> middles;
  for_each_triangle(mesh, [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    if (squared_edge_ratio(a, b, c) >= kLeastSquaredEdgeRatio) return;
    const Vec3 middle = middle_of(a, b, c);
    if (within.empty() || within.hold(middle)) middles.push_back(middle);
  });
  return middles;
}

/// The middles of the edges in the places, or of all if there are none, with a dihedral angle below
/// 60 degrees.
std::vector<Vec3> sharp_edges(Backend& backend, const TriangleMesh& mesh, const Places& within) {
  constexpr std::size_t kGrain = 4096;
  const VertexCorners corners = vertex_corners(backend, mesh);
  const auto normal_of = [&](std::uint32_t c) {
    const std::uint32_t* v = &mesh.triangles[c / 3 * 3];
    const Vec3 a = vertex_at(mesh, v[0]);
    return normalised(cross(vertex_at(mesh, v[1]) - a, vertex_at(mesh, v[2]) - a));
  };
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<Vec3>& middles) {
    for (std::size_t v = begin; v < end; ++v)
      for_each_shared_edge_up(
          mesh, corners, static_cast<std::uint32_t>(v), [&](std::uint32_t c, std::uint32_t d) {
            if (!(dot(normal_of(c), normal_of(d)) < kSharpBend)) return;
            const Vec3 middle = 0.5f * (vertex_at(mesh, v) +
                                        vertex_at(mesh, mesh.triangles[c / 3 * 3 + (c + 1) % 3]));
            if (within.empty() || within.hold(middle)) middles.push_back(middle);
          });
  };
  return collect<Vec3>(backend, mesh.vertex_count(), kGrain, find);
}

/// Places with the same factors in their middles, and longer edges from there out.
std::vector<CarefulPlace> graded(std::span<const CarefulPlace> places) {
  std::vector<CarefulPlace> balls;
  for (const CarefulPlace& place : places)
    for (std::size_t i = 0; i < std::size(kGrowth); ++i)
      balls.push_back({place.centre, place.radius * static_cast<float>(i + 1) / std::size(kGrowth),
                       std::max(place.factor, std::min(place.factor * kGrowth[i], 1.0f))});
  return balls;
}

/// A place, and what has been cut out round it to be mended by itself.
struct Cutting {
  CarefulPlace place;
  TriangleMesh mesh, solid;
  Faults faults;  ///< that are left in the end
  bool is_better = false;
  std::size_t work = 0;  ///< triangles that the tries have worked on

  static constexpr float kReached = kSpread + kReach;  // beyond the place: of its work
  Places reached() const { return wider(std::span(&place, 1), kReached); }
};

/// A byte a triangle: whether all its corners lie in what is cut out round one of the places, and
/// of which, from 1 on; else 0.
/// \pre the places are apart.
std::vector<std::uint8_t> cuttings_of(Backend& backend, std::span<const CarefulPlace> places,
                                      const TriangleMesh& mesh) {
  constexpr std::size_t kGrain = 4096;
  std::vector<std::uint8_t> vertex(mesh.vertex_count(), 0);
  for_each_index(backend, vertex.size(), kGrain, [&](std::size_t v) {
    for (std::size_t i = 0; i < places.size(); ++i)
      if (places[i].holds(vertex_at(mesh, v), Cutting::kReached + kCollar))
        vertex[v] = static_cast<std::uint8_t>(i + 1);
  });
  std::vector<std::uint8_t> triangle(mesh.triangle_count());
  for (std::size_t t = 0; t < triangle.size(); ++t) {
    const std::uint32_t* v = &mesh.triangles[3 * t];
    if (vertex[v[0]] == vertex[v[1]] && vertex[v[1]] == vertex[v[2]]) triangle[t] = vertex[v[0]];
  }
  return triangle;
}

/// Whether what is cut out round one place is apart from what is cut out round the other.
bool are_apart(const CarefulPlace& a, const CarefulPlace& b) {
  constexpr float kSlack = 0.01f;
  const float reach = (a.radius + b.radius) + 2 * (Cutting::kReached + kCollar) + kSlack;
  return squared_norm(a.centre - b.centre) > reach * reach;
}

/// The first places, at most kTogether, that are apart from all that wait before them.
std::vector<std::size_t> next_places(std::span<const CarefulPlace> places,
                                     std::span<const std::size_t> waiting) {
  std::vector<std::size_t> next;
  for (std::size_t i = 0; i < waiting.size() && next.size() < kTogether; ++i)
    if (std::all_of(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(i),
                    [&](std::size_t w) { return are_apart(places[w], places[waiting[i]]); }))
      next.push_back(waiting[i]);
  return next;
}

class Settling {
 public:
  Settling(Backend& backend, const FieldView& field, const SizeView& sizes, const Bounds& bounds)
      : backend_(backend), field_(field), sizes_(sizes), bounds_(bounds) {}

  /// The vertices near the places brought back to the base surface and to marching cubes, then the
  /// surface there to all of marching cubes; then the triangles of poor shape are
  /// mended.
  TriangleMesh approached(const TriangleMesh& solid, const Places& places,
                          TriangleMesh mesh) const {
    const float near = kNearShare * bounds_.limit;
    mesh = bring_back(backend_, field_, sizes_, bounds_.base, bounds_.base_tree, kStray,
                      std::move(mesh), places);
    mesh = bring_back(backend_, field_, sizes_, bounds_.solid.common, bounds_.solid_tree, near,
                      std::move(mesh), places);
    const std::vector<Vec3> far =
        points_beyond(backend_, near, solid, mesh, build_triangle_tree(backend_, mesh), places);
    return mended(approach(backend_, field_, sizes_, far, near, std::move(mesh)), places);
  }

  /// The surface with its small angles made wider, and near the places with edges of more equal
  /// lengths and without sharp ones.
  TriangleMesh mended(TriangleMesh mesh, const Places& within) const {
    std::vector<Vec3> poor = uneven_triangles(mesh, within);
    Faults faults;
    find_poor_triangles(mesh, faults);
    for (const std::vector<Vec3>& more : {faults.within({}), sharp_edges(backend_, mesh, within)})
      poor.insert(poor.end(), more.begin(), more.end());
    if (poor.empty()) return mesh;
    const Places places(places_at(poor, kMending, 1));
    const RemeshGoal goal = {field_, sizes_, &places, true};
    WorkingSurface surface = make_working_surface(backend_, goal, mesh);
    for (int round = 0; round < kMendingRounds; ++round)
      for_each_block(backend_, {block_side(sizes_), 0.1f + 0.3f * static_cast<float>(round)},
                     surface, [](PatchMesh& part) {
                       even_edges(part, kEveningPasses);
                       widen_angles(part, kWideningPasses);
                       open_dihedrals(part, kOpeningPasses);
                     });
    return make_mesh(backend_, surface);
  }

  /// \param solid  the segmentation's marching cubes, or what of it is near.
  /// \param places  if any: where the mesh is new. \param known  points too far before.
  /// \param met  if known: where triangles met before.
  Faults faults_of(const TriangleMesh& mesh, const TriangleMesh& solid, const Places& places,
                   const std::vector<Vec3>& known, const std::vector<Vec3>* met = nullptr) const {
    Faults faults;
    if (!places.empty())
      std::copy_if(known.begin(), known.end(), std::back_inserter(faults.far),
                   [&](const Vec3& p) { return !places.hold(p, Places::kMargin); });
    const TriangleTree tree = build_triangle_tree(backend_, mesh);
    add_far_points(mesh, tree, solid, places, faults.far);
    faults.meeting = met ? meeting_in(places, mesh, *met)
                         : centres_of(mesh, find_intersections(backend_, mesh, tree).pairs);
    find_poor_triangles(mesh, faults);
    return faults;
  }

  /// The points of the surface and of all marching cubes that are too far from each other.
  std::vector<Vec3> far_points_of(const TriangleMesh& mesh) const {
    std::vector<Vec3> far;
    add_far_points(mesh, build_triangle_tree(backend_, mesh), bounds_.solid.all, {}, far);
    return far;
  }

  /// Once more near the points that are too far: what has been mended may have left them. Kept if
  /// it is better. \return the faults then.
  Faults bring_nearer(Faults faults, TriangleMesh& mesh) const {
    if (faults.far.empty()) return faults;
    const std::vector<CarefulPlace> places = places_at(faults.far, kMending, 1);
    TriangleMesh nearer = approached(bounds_.solid.all, Places(places), mesh);
    Faults left =
        faults_of(nearer, bounds_.solid.all, wider(places, kReach), faults.far, &faults.meeting);
    if (left.counts() >= faults.counts()) return faults;
    mesh = std::move(nearer);
    return left;
  }

  /// One try: the mesh remeshed in the places and brought near again. \return its faults.
  Faults remake(std::span<const CarefulPlace> places, const TriangleMesh& solid,
                const Places& reached, TriangleMesh& mesh) const {
    mesh = remesh_places(backend_, field_, sizes_, mesh, graded(places));
    mesh = approached(solid, Places(places), std::move(mesh));
    Faults faults = faults_of(mesh, solid, reached, {});
    for (int again = 0; again < kAgain && !faults.far.empty(); ++again) {
      mesh = approached(solid, wider(places, kSpread), std::move(mesh));
      faults = faults_of(mesh, solid, reached, {});
    }
    return faults;
  }

  /// Tries to make a place better: chains of tries, each chain from the best so far.
  /// \param most  triangles that may be worked on.
  void mend(std::size_t most, Cutting& cut) const {
    if (cut.mesh.triangles.empty()) return;
    const std::span own(&cut.place, 1);
    const Places reached = cut.reached();
    cut.faults = faults_of(cut.mesh, cut.solid, reached, {});
    TriangleMesh mesh;
    Faults faults;
    for (std::size_t i = 0; i < std::size(kFactors); ++i) {
      // Sheets that run through each other after so many tries do not come apart in later ones.
      if (i == kHalf && !cut.faults.meeting.empty()) break;
      if (i % kChain == 0) {
        mesh = cut.mesh;
        faults = cut.faults;
      }
      const Places spots = i == 0 ? Places(own) : wider(own, kSpread);
      const std::vector<CarefulPlace> places =
          places_at(faults.within(spots), kPart[i / kHalf] * cut.place.radius, kFactors[i]);
      if (places.empty() && i % kChain == 0) break;
      if (places.empty()) continue;
      cut.work += std::max(
          {mesh.triangle_count(), faults.far.size(), cut.solid.triangle_count() / kSolidShare});
      if (cut.work >= most) break;
      faults = remake(places, cut.solid, reached, mesh);
      if (faults.counts() >= cut.faults.counts()) continue;
      cut.mesh = mesh;
      cut.faults = faults;
      cut.is_better = true;
    }
  }

  /// Mends places that are apart at the same time. \return what is left of each.
  std::vector<Cutting> mend_together(std::span<const CarefulPlace> places, std::size_t most,
                                     Settled& settled) const {
    std::vector<std::uint8_t> cutting = cuttings_of(backend_, places, settled.mesh);
    std::vector<TriangleMesh> meshes = parts_of(settled.mesh, cutting, places.size());
    std::vector<TriangleMesh> solids = parts_of(
        bounds_.solid.all, cuttings_of(backend_, places, bounds_.solid.all), places.size());
    std::vector<Cutting> cuts(places.size());
    backend_.run(places.size(), [&](std::size_t i) {
      cuts[i] = {places[i], std::move(meshes[i]), std::move(solids[i]), {}, false, 0};
      mend(most, cuts[i]);
    });
    put_back(cuts, std::move(cutting), settled);
    return cuts;
  }

  /// Mends all places and those that come of that, in turn: each finds the surface as those before
  /// it that reach as far have left it. \param work  triangles that may be worked on, about; what
  /// is left of them.
  void mend_all(std::vector<CarefulPlace> places, float radius, std::size_t& work,
                Settled& settled) const {
    for (std::size_t first = 0; first < places.size() && work > 0;) {
      const std::size_t end = places.size();
      std::vector<std::size_t> waiting(end - first);
      std::iota(waiting.begin(), waiting.end(), first);
      std::vector<std::vector<Vec3>> left(end);
      while (!waiting.empty() && work > 0) {
        const std::vector<std::size_t> next = next_places(places, waiting);
        std::vector<CarefulPlace> together;
        for (const std::size_t i : next) together.push_back(places[i]);
        const std::vector<Cutting> cuts = mend_together(together, work, settled);
        for (std::size_t i = 0; i < cuts.size(); ++i) {
          work -= std::min(work, cuts[i].work);
          if (cuts[i].is_better) left[next[i]] = cuts[i].faults.within(cuts[i].reached());
          std::erase(waiting, next[i]);
        }
      }
      for (; first < end; ++first) add_places(left[first], radius, 1, places);
    }
  }

 private:
  /// Of triangles in the places alone, if there are any.
  void add_far_points(const TriangleMesh& mesh, const TriangleTree& tree, const TriangleMesh& solid,
                      const Places& places, std::vector<Vec3>& far) const {
    for (const std::vector<Vec3>& found :
         {points_beyond(backend_, kFarShare * bounds_.limit, solid, mesh, tree, places),
          points_beyond(backend_, kMostShare * bounds_.limit, mesh, bounds_.solid.common,
                        bounds_.solid_tree, places)})
      far.insert(far.end(), found.begin(), found.end());
  }

  /// Puts those that are better in the place of what was cut out.
  void put_back(std::span<const Cutting> cuts, std::vector<std::uint8_t> cutting,
                Settled& settled) const {
    TriangleMesh better;
    for (const Cutting& cut : cuts)
      if (cut.is_better) better = joined(std::move(better), cut.mesh);
    if (better.triangles.empty()) return;
    for (std::uint8_t& c : cutting) c = c > 0 && cuts[c - 1].is_better;
    settled.mesh = with_part(backend_, settled.mesh, cutting, better);
    for (const Cutting& cut : cuts) {
      if (!cut.is_better) continue;
      const Places reached = cut.reached();
      std::erase_if(settled.far, [&](const Vec3& p) { return reached.hold(p, Places::kMargin); });
      settled.far.insert(settled.far.end(), cut.faults.far.begin(), cut.faults.far.end());
    }
  }

  /// Where triangles meet after the mesh has changed in the places alone.
  std::vector<Vec3> meeting_in(const Places& places, const TriangleMesh& mesh,
                               const std::vector<Vec3>& met) const {
    const auto is_near = [&](const Vec3& p) { return places.hold(p, Places::kMargin); };
    std::vector<std::uint8_t> chosen(mesh.triangle_count());
    for (std::size_t c = 0; c < mesh.triangles.size(); ++c)
      chosen[c / 3] |= is_near(vertex_at(mesh, mesh.triangles[c]));
    const TriangleMesh part = part_of(backend_, mesh, chosen);
    std::vector<Vec3> meeting = centres_of(
        part, find_intersections(backend_, part, build_triangle_tree(backend_, part)).pairs);
    std::erase_if(meeting, [&](const Vec3& p) { return !is_near(p); });
    std::copy_if(met.begin(), met.end(), std::back_inserter(meeting),
                 [&](const Vec3& p) { return !is_near(p); });
    return meeting;
  }

  Backend& backend_;
  const FieldView& field_;
  const SizeView& sizes_;
  const Bounds& bounds_;
};

}  // namespace

Settled settle(Backend& backend, const FieldView& field, const SizeView& sizes,
               const Bounds& bounds, float radius, TriangleMesh mesh,
               std::span<const CarefulPlace> within, const std::vector<Vec3>& far,
               std::size_t& work) {
  if (mesh.triangles.empty()) return {std::move(mesh), {}};
  const Settling settling(backend, field, sizes, bounds);
  Settled settled;
  settled.mesh = settling.approached(bounds.solid.all, Places(within), std::move(mesh));
  const Faults faults = settling.bring_nearer(
      settling.faults_of(settled.mesh, bounds.solid.all, wider(within, kReach), far), settled.mesh);
  settled.far = faults.far;
  settling.mend_all(places_at(faults.within({}), radius, 1), radius, work, settled);
  // What is far on triangles that reach out of a place has not been looked for there.
  if (sizes.elsewhere > kReach) settled.far = settling.far_points_of(settled.mesh);
  return settled;
}

}  // namespace vasamesh
