#include "stages/pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>
#include <vector>

#include "backend/ranges.h"
#include "stages/rays.h"
#include "types/volume.h"

namespace vasamesh {

namespace {

constexpr std::int64_t kVoters = 9;  // voxels of a piece that choose its shell
constexpr std::size_t kGrain = 64;   // pieces a task takes
constexpr int kNear = 2;             // voxels along each axis between a shell and its piece

/// A padded voxel.
struct Voxel {
  int x, y, z;
};

/// The coordinates of a voxel's centre in the surface's space.
std::array<float, 3> centre_of(const SolidMatch& match, const Voxel& voxel) {
  const Geometry& g = match.geometry;
  const double along[3] = {g.spacing[0] * (voxel.x - kPad), g.spacing[1] * (voxel.y - kPad),
                           g.spacing[2] * (voxel.z - kPad)};
  std::array<float, 3> centre;
  for (std::size_t row = 0; row < 3; ++row) {
    double x = along[row];
    if (match.space != Space::voxel) {
      x = g.origin[row];
      for (std::size_t a = 0; a < 3; ++a) x += g.direction[3 * row + a] * along[a];
    }
    centre[row] = static_cast<float>(match.space == Space::ras && row < 2 ? -x : x);
  }
  return centre;
}

/// The padded voxel that holds a point of the surface's space, at most a million away.
Voxel voxel_at(const SolidMatch& match, const float* point) {
  const Geometry& g = match.geometry;
  const double sign = match.space == Space::ras ? -1 : 1;
  const std::array<double, 3> x = {sign * point[0], sign * point[1], point[2]};
  std::array<int, 3> voxel;
  for (std::size_t a = 0; a < 3; ++a) {
    double along = x[a];
    if (match.space != Space::voxel) {
      along = 0;
      for (std::size_t b = 0; b < 3; ++b) along += g.direction[3 * b + a] * (x[b] - g.origin[b]);
    }
    voxel[a] =
        static_cast<int>(std::clamp(std::floor(along / g.spacing[a] + 0.5), -1e6, 1e6)) + kPad;
  }
  return {voxel[0], voxel[1], voxel[2]};
}

/// The voxels of each piece that choose its shell: the middles of runs, evenly spread.
std::vector<std::vector<Voxel>> choose_voters(const PieceLookup& lookup, std::size_t pieces) {
  std::vector<std::int64_t> runs(pieces, 0), seen(pieces, 0);
  for (const std::int32_t piece : lookup.piece)
    if (piece != PieceLookup::kNone) ++runs[piece];
  std::vector<std::vector<Voxel>> voters(pieces);
  const RunTable& table = lookup.table;
  for (std::size_t row = 0; row + 1 < table.row_first.size(); ++row)
    for (std::uint32_t r = table.row_first[row]; r < table.row_first[row + 1]; ++r) {
      const std::int32_t piece = lookup.piece[r];
      if (piece == PieceLookup::kNone) continue;
      const std::int64_t stride = (runs[piece] + kVoters - 1) / kVoters;
      if (seen[piece]++ % stride != 0) continue;
      const int y = static_cast<int>(row % table.size[1]),
                z = static_cast<int>(row / table.size[1]);
      voters[piece].push_back({(table.runs[r].begin + table.runs[r].end - 1) / 2, y, z});
    }
  return voters;
}

/// The outward shell round the part of the solid that a shell bounds.
std::uint32_t outward_shell(const Shells& shells, std::uint32_t shell) {
  for (std::size_t steps = 0; shell != Shells::kNone && !shells.shells[shell].outward(); ++steps) {
    if (steps == shells.shells.size()) return Shells::kNone;
    shell = shells.shells[shell].next;
  }
  return shell;
}

/// The outward shell round a point of the solid; kNone for a point outside.
std::uint32_t shell_round(const TriangleMesh& mesh, const RayCaster& rays, const Shells& shells,
                          const std::array<float, 3>& point) {
  double nearest = std::numeric_limits<double>::infinity();
  std::uint32_t shell = Shells::kNone;
  rays.cast(point.data(), [&](const RayCrossing& crossing) {
    if (crossing.x >= nearest) return;
    nearest = crossing.x;
    shell = crossing.exit ? shells.shell_of[mesh.triangles[3 * std::size_t{crossing.triangle}]]
                          : Shells::kNone;
  });
  return outward_shell(shells, shell);
}

/// The outward shell that each piece's voxels agree on; kNone for none.
std::vector<std::uint32_t> chosen_shells(Backend& backend, const TriangleMesh& mesh,
                                         const TriangleTree& tree, const Shells& shells,
                                         const SolidMatch& match) {
  const RayCaster rays(mesh, tree);
  const std::size_t pieces = match.solid->findings.pieces.size();
  const auto voters = choose_voters(match.solid->lookup, pieces);
  std::vector<std::uint32_t> chosen(pieces, Shells::kNone);
  for_each_index(backend, pieces, kGrain, [&](std::size_t p) {
    bool agreed = true;
    for (const Voxel& voxel : voters[p]) {
      const std::uint32_t shell = shell_round(mesh, rays, shells, centre_of(match, voxel));
      if (shell == Shells::kNone) continue;
      agreed = agreed && (chosen[p] == Shells::kNone || chosen[p] == shell);
      chosen[p] = shell;
    }
    if (!agreed) chosen[p] = Shells::kNone;
  });
  return chosen;
}

/// Shells that are chosen by two pieces are chosen by none.
void drop_contested(std::vector<std::uint32_t>& chosen, std::size_t shells) {
  std::vector<std::uint8_t> choices(shells, 0);
  for (const std::uint32_t shell : chosen)
    if (shell != Shells::kNone) choices[shell] += choices[shell] < 2;
  for (std::uint32_t& shell : chosen)
    if (shell != Shells::kNone && choices[shell] == 2) shell = Shells::kNone;
}

/// What each outward shell bounds, with the inward ones in it; nothing for the inward ones.
/// \param strays  counts inward shells that lie in no outward one.
std::vector<Topology> bounded_solids(const Shells& shells, std::int64_t& strays) {
  std::vector<Topology> solids(shells.shells.size());
  for (std::size_t s = 0; s < solids.size(); ++s) {
    const std::uint32_t owner = outward_shell(shells, static_cast<std::uint32_t>(s));
    if (owner == Shells::kNone) {
      ++strays;
      continue;
    }
    (shells.shells[s].outward() ? solids[owner].pieces : solids[owner].cavities)++;
    solids[owner].handles += shells.shells[s].genus();
  }
  return solids;
}

/// Whether a voxel of a piece that no shell was chosen for lies near a vertex of the shell.
bool near_a_left_piece(const TriangleMesh& mesh, const Shell& shell, const SolidMatch& match,
                       const std::vector<std::uint32_t>& chosen) {
  const Voxel at = voxel_at(match, mesh.vertices.data() + 3 * std::size_t{shell.first_vertex});
  for (int z = at.z - kNear; z <= at.z + kNear; ++z)
    for (int y = at.y - kNear; y <= at.y + kNear; ++y)
      for (int x = at.x - kNear; x <= at.x + kNear; ++x) {
        const std::int32_t piece = match.solid->lookup.at(x, y, z);
        if (piece != PieceLookup::kNone && chosen[piece] == Shells::kNone) return true;
      }
  return false;
}

/// The larger of what each list has that the other has not.
std::int64_t count_differences(std::vector<Topology>& a, std::vector<Topology>& b) {
  const auto before = [](const Topology& s, const Topology& t) {
    return std::tie(s.handles, s.cavities, s.pieces) < std::tie(t.handles, t.cavities, t.pieces);
  };
  std::sort(a.begin(), a.end(), before);
  std::sort(b.begin(), b.end(), before);
  std::vector<Topology> common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common), before);
  return static_cast<std::int64_t>(std::max(a.size(), b.size()) - common.size());
}

}  // namespace

std::int64_t count_mismatches(Backend& backend, const TriangleMesh& mesh, const TriangleTree& tree,
                              const Shells& shells, const SolidMatch& match) {
  const std::vector<Piece>& pieces = match.solid->findings.pieces;
  std::vector<std::uint32_t> chosen = chosen_shells(backend, mesh, tree, shells, match);
  drop_contested(chosen, shells.shells.size());
  std::int64_t mismatches = 0;
  std::vector<Topology> solids = bounded_solids(shells, mismatches);
  std::vector<Topology> left_pieces, left_solids;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const Topology wanted = {1, pieces[p].handles, pieces[p].cavities};
    if (chosen[p] == Shells::kNone) {
      left_pieces.push_back(wanted);
      continue;
    }
    mismatches += solids[chosen[p]] != wanted;
    solids[chosen[p]] = {};
  }
  for (std::size_t s = 0; s < solids.size(); ++s) {
    if (solids[s].pieces == 0) continue;
    if (near_a_left_piece(mesh, shells.shells[s], match, chosen))
      left_solids.push_back(solids[s]);
    else
      ++mismatches;
  }
  return mismatches + count_differences(left_pieces, left_solids);
}

}  // namespace vasamesh
