#include "stages/settle.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>

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
constexpr std::size_t kWork = 3, kLeastWork = 100000;  // of all tries: times the mesh's triangles
constexpr float kMending = 2;  // voxel lengths round a triangle of poor shape
constexpr float kBlock = 32;   // voxel lengths
constexpr int kMendingRounds = 2, kEveningPasses = 4, kWideningPasses = 12;
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
    const float sine = least_sine(squared_norm(b - a), squared_norm(c - b), squared_norm(a - c),
                                  squared_norm(cross(b - a, c - a)));
    if (sine < kSine20) (sine < kSine10 ? faults.sharp : faults.poor).push_back(middle_of(a, b, c));
  });
}

/// The middles of the triangles in the places, or of all if there are none, with an edge more than
/// 1.5 times as long as another.
std::vector<Vec3> uneven_triangles(const TriangleMesh& mesh, const Places& within) {
  std::vector<Vec3> middles;
  for_each_triangle(mesh, [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    if (edge_equality(a, b, c) >= kLeastEquality) return;
    const Vec3 middle = middle_of(a, b, c);
    if (within.empty() || within.hold(middle)) middles.push_back(middle);
  });
  return middles;
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

/// A byte a triangle: whether all its corners are in the places.
std::vector<std::uint8_t> triangles_in(Backend& backend, const Places& places,
                                       const TriangleMesh& mesh) {
  const std::vector<std::uint8_t> vertices = vertices_in(backend, places, mesh);
  std::vector<std::uint8_t> triangles(mesh.triangle_count());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    triangles[t] = vertices[mesh.triangles[3 * t]] && vertices[mesh.triangles[3 * t + 1]] &&
                   vertices[mesh.triangles[3 * t + 2]];
  return triangles;
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

  /// The surface with its small angles made wider, and with edges of more equal lengths near the
  /// places.
  TriangleMesh mended(TriangleMesh mesh, const Places& within) const {
    std::vector<Vec3> poor = uneven_triangles(mesh, within);
    Faults faults;
    find_poor_triangles(mesh, faults);
    const std::vector<Vec3> sharp = faults.within({});
    poor.insert(poor.end(), sharp.begin(), sharp.end());
    if (poor.empty()) return mesh;
    const Places places(places_at(poor, kMending, 1));
    const RemeshGoal goal = {field_, sizes_, &places, true};
    WorkingSurface surface = make_working_surface(backend_, goal, mesh);
    for (int round = 0; round < kMendingRounds; ++round)
      for_each_block(backend_, {kBlock, 0.1f + 0.5f * static_cast<float>(round)}, surface,
                     [](PatchMesh& part) {
                       even_edges(part, kEveningPasses);
                       widen_angles(part, kWideningPasses);
                     });
    return make_mesh(surface);
  }

  /// \param solid  the segmentation's marching cubes, or what of it is near.
  /// \param places  if any: where the mesh is new. \param known  points too far before.
  Faults faults_of(const TriangleMesh& mesh, const TriangleMesh& solid, const Places& places,
                   const std::vector<Vec3>& known) const {
    Faults faults;
    if (!places.empty())
      std::copy_if(known.begin(), known.end(), std::back_inserter(faults.far),
                   [&](const Vec3& p) { return !places.hold(p, Places::kMargin); });
    const TriangleTree tree = build_triangle_tree(backend_, mesh);
    for (const std::vector<Vec3>& found :
         {points_beyond(backend_, kFarShare * bounds_.limit, solid, mesh, tree, places),
          points_beyond(backend_, kMostShare * bounds_.limit, mesh, bounds_.solid.common,
                        bounds_.solid_tree, places)})
      faults.far.insert(faults.far.end(), found.begin(), found.end());
    faults.meeting = centres_of(mesh, find_intersections(backend_, mesh, tree).pairs);
    find_poor_triangles(mesh, faults);
    return faults;
  }

  /// Once more near the points that are too far: what has been mended may have left them. Kept if
  /// it is better. \return the faults then.
  Faults bring_nearer(Faults faults, TriangleMesh& mesh) const {
    if (faults.far.empty()) return faults;
    const std::vector<CarefulPlace> places = places_at(faults.far, kMending, 1);
    TriangleMesh nearer = approached(bounds_.solid.all, Places(places), mesh);
    Faults left = faults_of(nearer, bounds_.solid.all, wider(places, kReach), faults.far);
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
  /// \param work  triangles that may still be worked on; goes down by those that were.
  /// \return the faults left in the place, and near it where they have moved.
  std::vector<Vec3> mend(const CarefulPlace& place, std::size_t& work, Settled& settled) const {
    const std::span own(&place, 1);
    const float reach = kSpread + place.radius + kReach;
    const Places zone = wider(own, reach + kCollar), reached = wider(own, reach);
    const std::vector<std::uint8_t> chosen = triangles_in(backend_, zone, settled.mesh);
    const TriangleMesh solid =
        part_of(bounds_.solid.all, triangles_in(backend_, zone, bounds_.solid.all));
    TriangleMesh best = part_of(settled.mesh, chosen);
    if (best.triangles.empty()) return {};
    Faults fewest = faults_of(best, solid, reached, {});
    const auto at_first = fewest.counts();
    TriangleMesh mesh;
    Faults faults;
    for (std::size_t i = 0; i < std::size(kFactors); ++i) {
      if (i % kChain == 0) {
        mesh = best;
        faults = fewest;
      }
      const Places spots = i == 0 ? Places(own) : wider(own, kSpread);
      const std::vector<CarefulPlace> places =
          places_at(faults.within(spots), kPart[i / kHalf] * place.radius, kFactors[i]);
      if (places.empty() && i % kChain == 0) break;
      if (places.empty()) continue;
      work -= std::min(work, mesh.triangle_count());
      if (work == 0) break;
      faults = remake(places, solid, reached, mesh);
      if (faults.counts() >= fewest.counts()) continue;
      best = mesh;
      fewest = faults;
    }
    if (fewest.counts() == at_first) return {};
    settled.mesh = with_part(settled.mesh, chosen, best);
    std::erase_if(settled.far, [&](const Vec3& p) { return reached.hold(p, Places::kMargin); });
    settled.far.insert(settled.far.end(), fewest.far.begin(), fewest.far.end());
    return fewest.within(reached);
  }

 private:
  Backend& backend_;
  const FieldView& field_;
  const SizeView& sizes_;
  const Bounds& bounds_;
};

}  // namespace

Settled settle(Backend& backend, const FieldView& field, const SizeView& sizes,
               const Bounds& bounds, float radius, TriangleMesh mesh,
               std::span<const CarefulPlace> within, const std::vector<Vec3>& far) {
  if (mesh.triangles.empty()) return {std::move(mesh), {}};
  const Settling settling(backend, field, sizes, bounds);
  Settled settled;
  settled.mesh = settling.approached(bounds.solid.all, Places(within), std::move(mesh));
  const Faults faults = settling.bring_nearer(
      settling.faults_of(settled.mesh, bounds.solid.all, wider(within, kReach), far), settled.mesh);
  settled.far = faults.far;
  std::size_t work = kWork * settled.mesh.triangle_count() + kLeastWork;
  std::vector<CarefulPlace> places = places_at(faults.within({}), radius, 1);
  for (std::size_t i = 0; i < places.size() && work > 0; ++i) {
    const CarefulPlace place = places[i];
    add_places(settling.mend(place, work, settled), radius, 1, places);
  }
  return settled;
}

}  // namespace vasamesh
