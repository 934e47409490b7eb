#include "reference/lattice_reference.h"

#include <cstdlib>
#include <vector>

namespace vasamesh::reference {

namespace {

using Offset = std::array<int, 3>;

/// Whether two nodes of this difference span an edge of the Freudenthal cut.
bool is_edge(const Offset& d) {
  int up = 0, down = 0;
  for (const int c : d) {
    if (std::abs(c) > 1) return false;
    up += c > 0;
    down += c < 0;
  }
  return (up > 0) != (down > 0);
}

std::vector<Offset> link_inside(std::uint32_t labels) {
  std::vector<Offset> nodes;
  for (std::size_t i = 0; i < kLink.size(); ++i)
    if (labels >> i & 1) nodes.push_back({kLink[i].x, kLink[i].y, kLink[i].z});
  return nodes;
}

bool adjacent(const Offset& a, const Offset& b) {
  return is_edge({b[0] - a[0], b[1] - a[1], b[2] - a[2]});
}

int euler_characteristic(const std::vector<Offset>& nodes) {
  int sum = static_cast<int>(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (!adjacent(nodes[i], nodes[j])) continue;
      --sum;
      for (std::size_t k = 0; k < j; ++k)
        sum += adjacent(nodes[i], nodes[k]) && adjacent(nodes[j], nodes[k]);
    }
  return sum;
}

bool is_connected(const std::vector<Offset>& nodes) {
  if (nodes.empty()) return false;
  std::vector<bool> reached(nodes.size(), false);
  std::vector<std::size_t> stack{0};
  reached[0] = true;
  std::size_t count = 1;
  while (!stack.empty()) {
    const std::size_t from = stack.back();
    stack.pop_back();
    for (std::size_t to = 0; to < nodes.size(); ++to) {
      if (reached[to] || !adjacent(nodes[from], nodes[to])) continue;
      reached[to] = true;
      stack.push_back(to);
      ++count;
    }
  }
  return count == nodes.size();
}

}  // namespace

bool is_simple(std::uint32_t labels) {
  const std::vector<Offset> inside = link_inside(labels);
  return is_connected(inside) && euler_characteristic(inside) == 1;
}

bool is_face_centre(const DenseVolume& volume, int x, int y, int z) {
  const int odd = (x & 1) + (y & 1) + (z & 1);
  if (odd != 2) return false;
  const int i = x >> 1, j = y >> 1, k = z >> 1;
  return volume.object(i, j, k) != volume.object(i - !(x & 1), j - !(y & 1), k - !(z & 1));
}

bool near_face_centre(const DenseVolume& volume, const std::array<int, 3>& radius, int x, int y,
                      int z) {
  for (int c = z - radius[2]; c <= z + radius[2]; ++c)
    for (int b = y - radius[1]; b <= y + radius[1]; ++b)
      for (int a = x - radius[0]; a <= x + radius[0]; ++a)
        if (is_face_centre(volume, a, b, c)) return true;
  return false;
}

bool is_narrow(const NodePlaces& nodes, const std::vector<std::uint8_t>& state,
               const std::vector<float>& values, const LeastWidths& least,
               const std::array<int, 3>& at) {
  constexpr int kAxes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto label = [&](int dx, int dy, int dz) {
    const auto found = nodes.find({at[0] + dx, at[1] + dy, at[2] + dz});
    return found != nodes.end() && (state[found->second] & kLabel) != 0;
  };
  const bool inside = label(0, 0, 0);
  std::uint32_t link = 0;
  for (std::size_t i = 0; i < kLink.size(); ++i)
    link |= std::uint32_t{label(kLink[i].x, kLink[i].y, kLink[i].z)} << i;
  int closed = 0;
  bool narrow = false, thin_sheet = false;
  for (const auto& [dx, dy, dz] : kAxes) {
    const auto above = nodes.find({at[0] + dx, at[1] + dy, at[2] + dz});
    const auto below = nodes.find({at[0] - dx, at[1] - dy, at[2] - dz});
    if (above == nodes.end() || below == nodes.end()) continue;
    if (label(dx, dy, dz) == inside || label(-dx, -dy, -dz) == inside) continue;
    const double own = std::abs(values[nodes.at(at)]);
    double width = 0;
    for (const auto& other : {above, below})
      width += 0.5 * own / (own + std::abs(values[other->second]));
    ++closed;
    narrow = narrow || width < double{least.across};
    thin_sheet = thin_sheet || width < double{least.sheet};
  }
  return (at[0] & at[1] & at[2] & 1) && ((narrow && closed >= 2) || (thin_sheet && inside)) &&
         !is_simple(link);
}

DenseVolume relabelled(const DenseVolume& solid, const Lattice& lattice) {
  DenseVolume nodes = solid;
  const BrickView bricks = lattice.bricks.view();
  for (std::size_t b = 0; b < bricks.count; ++b)
    for (int c = 0; c < kBrickCells; ++c) {
      const int x = 8 * bricks.coords[b].x + c % 8, y = 8 * bricks.coords[b].y + c / 8 % 8,
                z = 8 * bricks.coords[b].z + c / 64;
      if (x >= nodes.size[0] || y >= nodes.size[1] || z >= nodes.size[2]) continue;
      nodes.at(x, y, z) =
          lattice.state.view().data()[kBrickCells * b + static_cast<std::size_t>(c)] & kLabel;
    }
  return nodes;
}

}  // namespace vasamesh::reference
