/// Small dihedral angles opened by geometry alone.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stages/patch_clearance.h"
#include "stages/patch_mending.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

using Corners = PatchMesh::Corners;

// Of cosines between the normals at the sharpest edge: the least by which one must grow.
constexpr float kGain = 0.03f, kGainOfAStep = 0.006f;
constexpr float kLastStep = 0.03f;  // of the mean edge round a vertex
constexpr float kMostMove = 0.5f;   // of the size

Vec3 normal_of(const PatchMesh& mesh, const Corners& triangle) {
  return normalised(
      area_vector(mesh.points[triangle[0]], mesh.points[triangle[1]], mesh.points[triangle[2]]));
}

float squared_sine_of(const PatchMesh& mesh, const Corners& triangle) {
  return least_squared_sine(mesh.points[triangle[0]], mesh.points[triangle[1]],
                            mesh.points[triangle[2]]);
}

/// The cosine between the normals of the triangles at the edge of h, which has two.
float bend_of(const PatchMesh& mesh, std::uint32_t h) {
  return dot(normal_of(mesh, mesh.corners(h)), normal_of(mesh, mesh.corners(mesh.twin(h))));
}

/// Triangles that may take the place of some.
class Change {
 public:
  std::vector<Corners> made;  ///< at first those whose place it is

  /// \param gone  half-edges, one a triangle.
  Change(const PatchMesh& mesh, std::span<const std::uint32_t> gone) : mesh_(mesh) {
    for (const std::uint32_t g : gone) made.push_back(mesh.corners(g));
    for (const std::uint32_t g : gone)
      for (const std::uint32_t h : {g, PatchMesh::next(g), PatchMesh::previous(g)})
        take_rim(gone, h);
  }

  /// The least cosine between normals at the edges of the triangles that are made.
  float sharpest() const {
    std::vector<Vec3> normals;
    for (const Corners& t : made) normals.push_back(normal_of(mesh_, t));
    float least = 1;
    for (std::size_t i = 0; i < made.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = made[i][k], to = made[i][(k + 1) % 3];
        for (const Rim& rim : rim_)
          if (rim.from == from && rim.to == to)
            least = std::min(least, dot(normals[i], rim.beyond));
        for (std::size_t j = 0; j < i; ++j)
          if (runs(made[j], to, from)) least = std::min(least, dot(normals[i], normals[j]));
      }
    return least;
  }

  float least_squared_sine() const {
    float least = 1;
    for (const Corners& t : made) least = std::min(least, squared_sine_of(mesh_, t));
    return least;
  }

 private:
  /// An edge of the triangles that go, and the normal of the triangle that stays beyond it.
  struct Rim {
    std::uint32_t from, to;
    Vec3 beyond;
  };

  void take_rim(std::span<const std::uint32_t> gone, std::uint32_t h) {
    const std::uint32_t t = mesh_.twin(h);
    const auto is_of_t = [&](std::uint32_t g) { return g / 4 == t / 4; };
    if (t == PatchMesh::kNone || std::any_of(gone.begin(), gone.end(), is_of_t)) return;
    rim_.push_back({mesh_.origin(h), mesh_.target(h), normal_of(mesh_, mesh_.corners(t))});
  }

  /// Whether the triangle has an edge in that direction.
  static bool runs(const Corners& t, std::uint32_t from, std::uint32_t to) {
    return (t[0] == from && t[1] == to) || (t[1] == from && t[2] == to) ||
           (t[2] == from && t[0] == to);
  }

  const PatchMesh& mesh_;
  std::vector<Rim> rim_;
};

class Opening {
 public:
  explicit Opening(PatchMesh& mesh) : mesh_(mesh), clearance_(mesh) {}

  /// One try at an edge: turned, or else its corners and apexes moved. \return whether anything has
  /// changed.
  bool open(std::uint32_t h) {
    if (turn(h)) return true;
    bool any = false;
    for (const std::uint32_t v :
         {mesh_.origin(h), mesh_.target(h), mesh_.apex(h), mesh_.apex(mesh_.twin(h))})
      any = move(v) || any;
    return any;
  }

 private:
  bool turn(std::uint32_t h) {
    if (!mesh_.may_flip(h)) return false;
    const std::uint32_t t = mesh_.twin(h), p = mesh_.origin(h), q = mesh_.target(h),
                        c = mesh_.apex(h), d = mesh_.apex(t);
    Change change(mesh_, std::array{h, t});
    const float before = change.sharpest(),
                squared_sine = std::min(kSquaredSine25, change.least_squared_sine());
    change.made = {{d, c, p}, {c, d, q}};
    return change.sharpest() > before + kGain && change.least_squared_sine() >= squared_sine &&
           clearance_.flip_if_clear(mesh_, h);
  }

  /// To where the sharpest edge of the triangles round v is least sharp.
  bool move(std::uint32_t v) {
    if (!mesh_.is_inner(v)) return false;
    std::vector<std::uint32_t> fan;
    mesh_.for_each_out(v, [&](std::uint32_t h) { fan.push_back(h); });
    const Change change(mesh_, fan);
    std::vector<float> squared_sines;
    for (const Corners& t : change.made)
      squared_sines.push_back(std::min(kSquaredSine25, squared_sine_of(mesh_, t)));
    const SurfacePoint old = mesh_.points[v];
    const float before = change.sharpest(), farthest = kMostMove * old.size;
    float most = before;
    const auto takes = [&](const SurfacePoint& point) {
      if (squared_norm(point.position - old.position) > farthest * farthest) return false;
      mesh_.points[v] = point;
      bool good = true;
      for (std::size_t i = 0; i < squared_sines.size(); ++i)
        good = good && squared_sine_of(mesh_, change.made[i]) >= squared_sines[i];
      const float found = good ? change.sharpest() : -1;
      mesh_.points[v] = old;
      if (!(found > most + kGainOfAStep)) return false;
      most = found;
      return true;
    };
    SurfacePoint place = search_around(mesh_, v, kLastStep, takes);
    place.on_field = false;
    return most > before + kGain && clearance_.move_if_clear(mesh_, v, place);
  }

  PatchMesh& mesh_;
  Clearance clearance_;
};

}  // namespace

void open_dihedrals(PatchMesh& mesh, int passes) {
  std::optional<Opening> opening;
  for (int pass = 0; pass < passes; ++pass) {
    bool any = false;
    for (std::uint32_t h = 0; h < mesh.half_edge_end(); ++h) {
      mesh.take_turn();
      // The half-edge of lower index stands for its edge.
      if (!mesh.is_edge(h) || mesh.twin(h) == PatchMesh::kNone || mesh.twin(h) < h) continue;
      if (!(bend_of(mesh, h) < kSharpBend)) continue;
      if (!opening) opening.emplace(mesh);
      any = opening->open(h) || any;
    }
    if (!any) return;
  }
}

}  // namespace vasamesh
