#include "stages/shells.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/predicates.h"

namespace vasamesh {

namespace {

constexpr std::size_t kShellsATask = 64;
constexpr std::size_t kVotes = 15;  // vertices of a shell that choose its piece
constexpr double kReach = 2;        // voxel lengths from a vertex to its piece

const float* vertex(const TriangleMesh& mesh, std::size_t v) {
  return mesh.vertices.data() + 3 * v;
}

std::vector<std::uint32_t> connect_vertices(const TriangleMesh& mesh,
                                            const std::vector<std::uint8_t>& valid) {
  std::vector<std::uint32_t> parent(mesh.vertex_count());
  for (std::size_t v = 0; v < parent.size(); ++v) parent[v] = static_cast<std::uint32_t>(v);
  const auto find = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  const auto unite = [&](std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent[std::max(a, b)] = std::min(a, b);
  };
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    if (!valid[t]) continue;
    unite(mesh.triangles[3 * t], mesh.triangles[3 * t + 1]);
    unite(mesh.triangles[3 * t], mesh.triangles[3 * t + 2]);
  }
  for (std::uint32_t& p : parent) p = parent[p];
  return parent;
}

/// Six times the volume of the tetrahedron from `origin` to a triangle.
double six_volumes(const TriangleMesh& mesh, std::size_t triangle, const float* origin) {
  double p[3][3];
  for (int i = 0; i < 3; ++i)
    for (int a = 0; a < 3; ++a)
      p[i][a] = double{vertex(mesh, mesh.triangles[3 * triangle + i])[a]} - origin[a];
  return p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
         p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
         p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
}

/// Sign of orient2d(a, b, p) along x, p moved by (e, e^2) in (y, z) for a vanishing e > 0.
int perturbed_side(const float* a, const float* b, const float* p) {
  if (const int side = orient2d(a, b, p, 0)) return side;
  if (a[2] != b[2]) return a[2] > b[2] ? 1 : -1;
  if (a[1] != b[1]) return b[1] > a[1] ? 1 : -1;
  return 0;
}

/// Whether the ray from p along +x, moved as above, crosses the triangle.
bool ray_crosses(const TriangleMesh& mesh, std::uint32_t triangle, const float* p) {
  const std::uint32_t* t = mesh.triangles.data() + 3 * std::size_t{triangle};
  const float *a = vertex(mesh, t[0]), *b = vertex(mesh, t[1]), *c = vertex(mesh, t[2]);
  const int side = perturbed_side(a, b, p);
  if (side == 0 || perturbed_side(b, c, p) != side || perturbed_side(c, a, p) != side) return false;
  return orient3d(a, b, c, p) == -side;
}

/// The vertex of largest x of each shell, the first among equals.
std::vector<std::uint32_t> farthest_vertices(const TriangleMesh& mesh, const Shells& shells) {
  std::vector<std::uint32_t> farthest(shells.shells.size());
  for (std::size_t s = 0; s < farthest.size(); ++s) farthest[s] = shells.shells[s].first_vertex;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const std::uint32_t s = shells.shell_of[v];
    if (s != Shells::kNone && vertex(mesh, v)[0] > vertex(mesh, farthest[s])[0])
      farthest[s] = static_cast<std::uint32_t>(v);
  }
  return farthest;
}

bool inside_others(const TriangleMesh& mesh, const TriangleTree& tree, const Shells& shells,
                   std::uint32_t shell, const float* p) {
  const Box ray{{p[0], p[1], p[2]}, {std::numeric_limits<float>::max(), p[1], p[2]}};
  bool odd = false;
  for_each_leaf(tree, ray, 0, [&](std::size_t leaf) {
    for (unsigned hits = meeting(tree.levels[0][leaf], ray); hits; hits &= hits - 1) {
      const std::uint32_t t = tree.order[8 * leaf + std::countr_zero(hits)];
      if (shells.shell_of[mesh.triangles[3 * std::size_t{t}]] == shell) continue;
      odd ^= ray_crosses(mesh, t, p);
    }
  });
  return odd;
}

/// From the written coordinates to padded voxel units.
class VoxelSpace {
 public:
  explicit VoxelSpace(const SolidMatch& match) : match_(match) {
    const auto& spacing = match.geometry.spacing;
    const double mean = std::cbrt(spacing[0] * spacing[1] * spacing[2]);
    for (int a = 0; a < 3; ++a) scale_[a] = spacing[a] / mean;
  }

  std::array<double, 3> to_padded(const float* p) const {
    const Geometry& g = match_.geometry;
    std::array<double, 3> x{p[0], p[1], p[2]}, voxel{};
    if (match_.space == Space::ras) x = {-x[0], -x[1], x[2]};
    for (int a = 0; a < 3; ++a) {
      double along = x[a];
      if (match_.space != Space::voxel) {
        along = 0;
        for (int b = 0; b < 3; ++b) along += g.direction[3 * b + a] * (x[b] - g.origin[b]);
      }
      voxel[a] = along / g.spacing[a] + 0.5 + kPad;
    }
    return voxel;
  }

  /// The piece of the object voxel nearest to a point, up to kReach away.
  std::int32_t nearest_piece(const std::array<double, 3>& p) const {
    Nearest best;
    const std::array<int, 3> near{1, 1, 1};
    search(p, near, best);
    // A voxel outside the search is at least one voxel away along some axis.
    if (best.distance > std::min({scale_[0], scale_[1], scale_[2]})) {
      std::array<int, 3> reach;
      for (int a = 0; a < 3; ++a) reach[a] = static_cast<int>(std::ceil(kReach / scale_[a]));
      search(p, reach, best);
    }
    return best.distance <= kReach ? best.piece : PieceLookup::kNone;
  }

 private:
  struct Nearest {
    double distance = std::numeric_limits<double>::infinity();
    std::int32_t piece = PieceLookup::kNone;
  };

  double from_centre(const std::array<double, 3>& p, const std::array<int, 3>& voxel) const {
    double square = 0;
    for (int a = 0; a < 3; ++a) {
      const double d = scale_[a] * (p[a] - voxel[a] - 0.5);
      square += d * d;
    }
    return std::sqrt(square);
  }

  void search(const std::array<double, 3>& p, const std::array<int, 3>& reach,
              Nearest& best) const {
    std::array<int, 3> home;
    for (int a = 0; a < 3; ++a) home[a] = static_cast<int>(std::clamp(std::floor(p[a]), -1e6, 1e9));
    for (int z = home[2] - reach[2]; z <= home[2] + reach[2]; ++z)
      for (int y = home[1] - reach[1]; y <= home[1] + reach[1]; ++y)
        for (int x = home[0] - reach[0]; x <= home[0] + reach[0]; ++x) {
          const std::int32_t piece = match_.solid->lookup.at(x, y, z);
          if (piece == PieceLookup::kNone) continue;
          // Boxes that meet are told apart by their centres.
          const double d = distance(p, {x, y, z}) + 0.1 * from_centre(p, {x, y, z});
          if (d < best.distance) best = {d, piece};
        }
  }

  /// From a point to a voxel's box, in voxel lengths.
  double distance(const std::array<double, 3>& p, const std::array<int, 3>& voxel) const {
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
      const double out = std::max({voxel[a] - p[a], p[a] - (voxel[a] + 1), 0.0}) * scale_[a];
      sum += out * out;
    }
    return std::sqrt(sum);
  }

  const SolidMatch& match_;
  std::array<double, 3> scale_;
};

/// The value that occurs most, the lowest among equals.
std::int32_t most_frequent(std::vector<std::int32_t>& values) {
  std::sort(values.begin(), values.end());
  std::int32_t best = PieceLookup::kNone;
  std::ptrdiff_t best_count = 0;
  for (auto first = values.begin(); first != values.end();) {
    const auto last = std::upper_bound(first, values.end(), *first);
    if (last - first > best_count) {
      best = *first;
      best_count = last - first;
    }
    first = last;
  }
  return best;
}

/// The vertices of each shell that vote for its piece, evenly spread over its indices.
std::vector<std::vector<std::uint32_t>> choose_voters(const Shells& shells) {
  std::vector<std::vector<std::uint32_t>> voters(shells.shells.size());
  std::vector<std::int64_t> seen(shells.shells.size(), 0);
  for (std::size_t v = 0; v < shells.shell_of.size(); ++v) {
    const std::uint32_t s = shells.shell_of[v];
    if (s == Shells::kNone) continue;
    const std::int64_t stride = std::max<std::int64_t>(1, shells.shells[s].vertices / kVotes);
    if (seen[s]++ % stride == 0 && voters[s].size() < kVotes)
      voters[s].push_back(static_cast<std::uint32_t>(v));
  }
  return voters;
}

/// Calls visit(shell) for all shells on the backend's workers.
template <class Visit>
void for_each_shell(Backend& backend, const Shells& shells, const Visit& visit) {
  const std::size_t count = shells.shells.size();
  backend.run((count + kShellsATask - 1) / kShellsATask, [&](std::size_t task) {
    for (std::size_t s = task * kShellsATask; s < std::min((task + 1) * kShellsATask, count); ++s)
      visit(static_cast<std::uint32_t>(s));
  });
}

}  // namespace

Shells find_shells(const TriangleMesh& mesh, const std::vector<std::uint8_t>& valid,
                   const ManifoldCounts& manifold) {
  const std::vector<std::uint32_t> root = connect_vertices(mesh, valid);
  Shells result;
  result.shell_of.assign(mesh.vertex_count(), Shells::kNone);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    if (!valid[t]) continue;
    std::uint32_t& shell = result.shell_of[root[mesh.triangles[3 * t]]];
    if (shell == Shells::kNone) {
      shell = static_cast<std::uint32_t>(result.shells.size());
      result.shells.push_back({});
      result.shells.back().first_vertex = root[mesh.triangles[3 * t]];
    }
    Shell& s = result.shells[shell];
    ++s.triangles;
    const double volume = six_volumes(mesh, t, vertex(mesh, s.first_vertex)) / 6;
    if (std::isfinite(volume)) s.volume += volume;
  }
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const std::uint32_t shell = result.shell_of[v] = result.shell_of[root[v]];
    if (shell == Shells::kNone) continue;
    ++result.shells[shell].vertices;
    result.shells[shell].edges += manifold.edges_up[v];
  }
  return result;
}

void find_nesting(Backend& backend, const TriangleMesh& mesh, const TriangleTree& tree,
                  Shells& shells) {
  if (shells.shells.size() < 2 || tree.empty()) return;
  const std::vector<std::uint32_t> farthest = farthest_vertices(mesh, shells);
  for_each_shell(backend, shells, [&](std::uint32_t s) {
    shells.shells[s].nested = inside_others(mesh, tree, shells, s, vertex(mesh, farthest[s]));
  });
}

void find_pieces(Backend& backend, const TriangleMesh& mesh, const SolidMatch& match,
                 Shells& shells) {
  const VoxelSpace space(match);
  const auto voters = choose_voters(shells);
  for_each_shell(backend, shells, [&](std::uint32_t s) {
    std::vector<std::int32_t> votes;
    for (std::uint32_t v : voters[s]) {
      const std::array<double, 3> p = space.to_padded(vertex(mesh, v));
      if (std::isfinite(p[0] + p[1] + p[2])) votes.push_back(space.nearest_piece(p));
    }
    shells.shells[s].piece = most_frequent(votes);
  });
}

}  // namespace vasamesh
