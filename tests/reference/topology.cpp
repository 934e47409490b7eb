#include "reference/topology.h"

#include <cstdlib>

namespace vasamesh::test {

namespace {

using Offset = std::array<int, 3>;

std::vector<Offset> voxel_neighbours(int connectivity) {
  std::vector<Offset> offsets;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        const int distance = std::abs(x) + std::abs(y) + std::abs(z);
        if (distance >= 1 && distance <= (connectivity == 6 ? 1 : connectivity == 18 ? 2 : 3))
          offsets.push_back({x, y, z});
      }
  return offsets;
}

std::vector<Offset> lattice_neighbours() {
  std::vector<Offset> offsets;
  for (int mask = 1; mask < 8; ++mask)
    for (int sign : {1, -1})
      offsets.push_back({sign * (mask & 1), sign * (mask >> 1 & 1), sign * (mask >> 2 & 1)});
  return offsets;
}

std::vector<int> flood(const DenseVolume& volume, bool value, const std::vector<Offset>& offsets) {
  std::vector<int> component(volume.voxels.size(), -1);
  int count = 0;
  const auto [nx, ny, nz] = volume.size;
  for (std::size_t seed = 0; seed < component.size(); ++seed) {
    if (component[seed] >= 0 || (volume.voxels[seed] != 0) != value) continue;
    std::vector<std::size_t> stack{seed};
    component[seed] = count;
    while (!stack.empty()) {
      const auto i = static_cast<int>(stack.back());
      stack.pop_back();
      for (const Offset& o : offsets) {
        const int x = i % nx + o[0], y = i / nx % ny + o[1], z = i / nx / ny + o[2];
        if (x < 0 || y < 0 || z < 0 || x >= nx || y >= ny || z >= nz) continue;
        const std::size_t j =
            x + static_cast<std::size_t>(nx) * (y + static_cast<std::size_t>(ny) * z);
        if (component[j] >= 0 || volume.object(x, y, z) != value) continue;
        component[j] = count;
        stack.push_back(j);
      }
    }
    ++count;
  }
  return component;
}

int count_of(const std::vector<int>& component) {
  int count = 0;
  for (int c : component) count = std::max(count, c + 1);
  return count;
}

DenseVolume padded(const DenseVolume& volume) {
  DenseVolume result({volume.size[0] + 2, volume.size[1] + 2, volume.size[2] + 2});
  for (int z = 0; z < volume.size[2]; ++z)
    for (int y = 0; y < volume.size[1]; ++y)
      for (int x = 0; x < volume.size[0]; ++x)
        result.at(x + 1, y + 1, z + 1) = volume.object(x, y, z);
  return result;
}

/// The voxels that touch the cell at (x, y, z) in half voxels: odd coordinates lie inside a voxel.
struct Touching {
  int count = 0, object = 0;
  std::vector<Offset> objects;
};

Touching voxels_at(const DenseVolume& volume, int x, int y, int z) {
  Touching touching;
  const auto range = [](int c) { return Offset{c % 2 ? c / 2 : c / 2 - 1, c / 2, 0}; };
  const Offset rx = range(x), ry = range(y), rz = range(z);
  for (int k = rz[0]; k <= rz[1]; ++k)
    for (int j = ry[0]; j <= ry[1]; ++j)
      for (int i = rx[0]; i <= rx[1]; ++i) {
        ++touching.count;
        if (!volume.object(i, j, k)) continue;
        ++touching.object;
        touching.objects.push_back({i, j, k});
      }
  return touching;
}

bool corner_contact(const DenseVolume& volume, int x, int y, int z) {
  if (x % 2 || y % 2 || z % 2) return false;
  const Touching t = voxels_at(volume, x, y, z);
  if (t.object != 2) return false;
  for (int a = 0; a < 3; ++a)
    if (t.objects[0][a] == t.objects[1][a]) return false;
  return true;
}

int euler_characteristic(const DenseVolume& volume, int connectivity) {
  int sum = 0;
  for (int z = 0; z <= 2 * volume.size[2]; ++z)
    for (int y = 0; y <= 2 * volume.size[1]; ++y)
      for (int x = 0; x <= 2 * volume.size[0]; ++x) {
        const Touching t = voxels_at(volume, x, y, z);
        const bool inside = connectivity == 6 ? t.object == t.count : t.object > 0;
        const int sign = (x % 2 + y % 2 + z % 2) % 2 ? -1 : 1;
        if (inside) sum += sign;
        // A trimmed corner leaves one corner on each of its two voxels.
        if (connectivity == 18 && corner_contact(volume, x, y, z)) ++sum;
      }
  return connectivity == 6 ? -sum : sum;
}

bool lattice_inside(const DenseVolume& volume, int connectivity, int x, int y, int z) {
  const Touching t = voxels_at(volume, x, y, z);
  if (connectivity == 6) return t.object == t.count;
  if (t.object == 0) return false;
  if (connectivity == 26) return true;
  if (x % 2 + y % 2 + z % 2 > 1) return true;
  if (corner_contact(volume, x, y, z)) return false;
  const Offset along{x % 2, y % 2, z % 2};
  if (along == Offset{0, 0, 0}) return true;
  return !corner_contact(volume, x - along[0], y - along[1], z - along[2]) &&
         !corner_contact(volume, x + along[0], y + along[1], z + along[2]);
}

/// Simplices of the Freudenthal cut with their lowest node at (x, y, z), with a sign a dimension:
/// chains of growing offset masks.
int simplices_at(const DenseVolume& nodes, int x, int y, int z) {
  const auto inside = [&](int mask) {
    return nodes.object(x + (mask & 1), y + (mask >> 1 & 1), z + (mask >> 2));
  };
  if (!inside(0)) return 0;
  int sum = 1;
  for (int a = 1; a < 8; ++a) {
    if (!inside(a)) continue;
    --sum;
    for (int b = a + 1; b < 8; ++b) {
      if ((a & b) != a || !inside(b)) continue;
      ++sum;
      if (b != 7 && inside(7)) --sum;
    }
  }
  return sum;
}

Topology from(int pieces, int cavities, int euler) {
  return {pieces, pieces + cavities - euler, cavities};
}

}  // namespace

std::vector<int> flood(const DenseVolume& volume, bool value, int connectivity) {
  return flood(volume, value, voxel_neighbours(connectivity));
}

Topology count_cells(const DenseVolume& volume, int connectivity) {
  const DenseVolume whole = padded(volume);
  return from(count_of(flood(whole, true, connectivity)),
              count_of(flood(whole, false, connectivity == 6 ? 26 : 6)) - 1,
              euler_characteristic(whole, connectivity));
}

std::vector<Topology> count_cells_by_piece(const DenseVolume& volume, int connectivity) {
  const std::vector<int> component = flood(volume, true, connectivity);
  std::vector<Topology> result;
  for (int c = 0; c < count_of(component); ++c) {
    DenseVolume piece = volume;
    for (std::size_t i = 0; i < component.size(); ++i) piece.voxels[i] = component[i] == c;
    result.push_back(count_cells(piece, connectivity));
  }
  return result;
}

DenseVolume solid_labels(const DenseVolume& volume, int connectivity) {
  DenseVolume nodes({2 * volume.size[0] + 1, 2 * volume.size[1] + 1, 2 * volume.size[2] + 1});
  for (int z = 0; z < nodes.size[2]; ++z)
    for (int y = 0; y < nodes.size[1]; ++y)
      for (int x = 0; x < nodes.size[0]; ++x)
        nodes.at(x, y, z) = lattice_inside(volume, connectivity, x, y, z);
  return nodes;
}

Topology count_nodes(const DenseVolume& nodes) {
  int euler = 0;
  for (int z = 0; z < nodes.size[2]; ++z)
    for (int y = 0; y < nodes.size[1]; ++y)
      for (int x = 0; x < nodes.size[0]; ++x) euler += simplices_at(nodes, x, y, z);
  return from(count_of(flood(nodes, true, lattice_neighbours())),
              count_of(flood(nodes, false, lattice_neighbours())) - 1, euler);
}

Topology count_lattice(const DenseVolume& volume, int connectivity) {
  return count_nodes(solid_labels(padded(volume), connectivity));
}

}  // namespace vasamesh::test
