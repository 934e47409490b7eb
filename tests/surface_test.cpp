/// \file
/// Marching tetrahedra of labelled lattices: the triangles of a tetrahedron-by-tetrahedron oracle,
/// closed and of the labels' topology for any labelling; and where the vertices lie.

#include "stages/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "reference/surface_reference.h"
#include "reference/topology.h"
#include "stages/bricks.h"
#include "stages/quality.h"
#include "support/backend_test.h"
#include "support/dense_volume.h"
#include "support/invariants.h"
#include "support/shapes.h"
#include "types/tetrahedra.h"
#include "types/volume.h"

namespace vasamesh {
namespace {

using test::DenseVolume;

class BaseSurface : public BackendTest {
 protected:
  /// The lattice of labels over whole bricks, with values of random size and the labels' signs;
  /// `tiny` makes most crossings lie at an edge's end.
  Lattice make_lattice(const DenseVolume& nodes, std::uint32_t seed, bool tiny = false) {
    std::vector<BrickCoord> coords;
    for (int z = 0; z < nodes.size[2] / 8; ++z)
      for (int y = 0; y < nodes.size[1] / 8; ++y)
        for (int x = 0; x < nodes.size[0] / 8; ++x) coords.push_back({x, y, z});
    std::mt19937 random(seed);
    std::vector<std::uint8_t> state;
    std::vector<float> values;
    for (const BrickCoord& b : coords)
      for (int c = 0; c < kBrickCells; ++c) {
        const bool inside = nodes.object(8 * b.x + c % 8, 8 * b.y + c / 8 % 8, 8 * b.z + c / 64);
        float size = (static_cast<float>(random() % 1000) + 1) / 1000;
        if (tiny && random() % 2) size *= 1e-6f;
        state.push_back(inside ? kLabel : kFree);
        values.push_back(inside ? size : -size);
      }
    Lattice lattice;
    lattice.bricks = make_bricks(backend(), coords);
    lattice.state = to_backend(backend(), state);
    lattice.values = to_backend(backend(), values);
    return lattice;
  }
};

/// Labels that leave the outermost nodes outside.
DenseVolume random_labels(const std::array<int, 3>& size, double density, unsigned seed) {
  DenseVolume nodes = test::random_volume(size, density, seed);
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x)
        if (x == 0 || y == 0 || z == 0 || x == size[0] - 1 || y == size[1] - 1 || z == size[2] - 1)
          nodes.at(x, y, z) = 0;
  return nodes;
}

/// All 256 labellings of a cube, each a cube's room away from the next.
DenseVolume all_cubes() {
  DenseVolume nodes({64, 64, 8});
  for (int labels = 0; labels < 256; ++labels)
    for (int c = 0; c < 8; ++c)
      nodes.at(4 * (labels % 16) + 1 + (c & 1), 4 * (labels / 16) + 1 + (c >> 1 & 1),
               1 + (c >> 2)) = labels >> c & 1;
  return nodes;
}

/// The lattice edge that a vertex lies on and how far along: all its coordinates in nodes that are
/// not whole move together.
struct OnEdge {
  reference::LatticeEdge edge;
  double part;
};

OnEdge locate(const TriangleMesh& mesh, std::uint32_t vertex) {
  OnEdge found{{}, 0.5};
  for (std::size_t i = 0; i < 3; ++i) {
    const double at = 2.0 * mesh.vertices[3 * vertex + i], below = std::floor(at);
    found.edge[0][i] = static_cast<int>(below);
    found.edge[1][i] = static_cast<int>(std::ceil(at));
    if (at != below) found.part = at - below;
  }
  return found;
}

std::vector<reference::EdgeTriangle> edge_triangles(const TriangleMesh& mesh) {
  std::vector<reference::EdgeTriangle> triangles;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    triangles.push_back(reference::turned({locate(mesh, mesh.triangles[t]).edge,
                                           locate(mesh, mesh.triangles[t + 1]).edge,
                                           locate(mesh, mesh.triangles[t + 2]).edge}));
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST_P(BaseSurface, EveryCaseOfTheTable) {
  const DenseVolume nodes = all_cubes();
  const TriangleMesh mesh = extract_base_surface(backend(), make_lattice(nodes, 1));
  EXPECT_EQ(edge_triangles(mesh), reference::marching_tetrahedra(nodes));
  test::expect_good_surface(mesh, test::count_nodes(nodes));
}

TEST(CubeCases, AreMirroredByTheirComplement) {
  for (std::size_t labels = 0; labels < 256; ++labels) {
    EXPECT_EQ(kCubeCases[labels].count, kCubeCases[255 - labels].count) << labels;
    EXPECT_LE(kCubeCases[labels].count, 12);
  }
  EXPECT_EQ(kCubeCases[0].count, 0);
  EXPECT_EQ(kCubeCases[1].count, 6);  // corner 0 lies on all six tetrahedra
  EXPECT_EQ(kCubeCases[2].count, 2);
}

TEST_P(BaseSurface, RandomLabellingsAreClosedAndOfTheLabelsTopology) {
  unsigned seed = 10;
  for (const double density : {0.03, 0.2, 0.5, 0.8, 1.0})
    for (const std::array<int, 3>& size : {std::array{16, 24, 16}, {40, 8, 8}}) {
      SCOPED_TRACE(::testing::Message() << "density " << density << ", " << size[0]);
      const DenseVolume nodes = random_labels(size, density, ++seed);
      const TriangleMesh mesh = extract_base_surface(backend(), make_lattice(nodes, seed, true));
      EXPECT_EQ(edge_triangles(mesh), reference::marching_tetrahedra(nodes));
      test::expect_good_surface(mesh, test::count_nodes(nodes));
    }
}

TEST_P(BaseSurface, VerticesLieWhereTheValuesVanishWithinTheirMargin) {
  const DenseVolume nodes = random_labels({24, 16, 16}, 0.3, 3);
  const Lattice lattice = make_lattice(nodes, 8, true);
  backend().settle();
  const BrickView bricks = lattice.bricks.view();
  const auto value_at = [&](const std::array<int, 3>& n) {
    for (std::size_t b = 0; b < bricks.count; ++b)
      if (bricks.coords[b] == BrickCoord{n[0] >> 3, n[1] >> 3, n[2] >> 3})
        return static_cast<double>(
            lattice.values.view().data()[kBrickCells * b + static_cast<std::size_t>(brick_cell(
                                                               n[0] & 7, n[1] & 7, n[2] & 7))]);
    return 0.0;
  };
  const TriangleMesh mesh = extract_base_surface(backend(), lattice);
  ASSERT_GT(mesh.vertex_count(), 1000u);
  int at_margin = 0, between = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const OnEdge on = locate(mesh, v);
    const double a = value_at(on.edge[0]), b = value_at(on.edge[1]);
    ASSERT_NE(a > 0, b > 0) << v;
    const double want = a / (a - b);
    ASSERT_NEAR(on.part, std::clamp<double>(want, kVertexMargin, 1 - kVertexMargin), 1e-5) << v;
    (want < kVertexMargin || want > 1 - kVertexMargin ? at_margin : between) += 1;
  }
  EXPECT_GT(at_margin, 100);
  EXPECT_GT(between, 100);
}

TEST_P(BaseSurface, NoLabelsGiveNoTriangles) {
  const TriangleMesh mesh =
      extract_base_surface(backend(), make_lattice(DenseVolume({8, 16, 8}), 1));
  EXPECT_EQ(mesh.vertex_count(), 0u);
  EXPECT_EQ(mesh.triangle_count(), 0u);
}

Geometry oblique(bool mirrored) {
  Geometry geometry;
  geometry.size = {30, 20, 10};
  geometry.spacing = {0.5, 0.75, 2};
  geometry.origin = {-100.25, 40, 1200};
  geometry.direction = {2 / 3.0,  -1 / 3.0, 2 / 3.0, 2 / 3.0, 2 / 3.0,
                        -1 / 3.0, -1 / 3.0, 2 / 3.0, 2 / 3.0};
  if (mirrored)
    for (std::size_t i = 2; i < 9; i += 3) geometry.direction[i] *= -1;
  return geometry;
}

TEST_P(BaseSurface, PlacedInEachSpaceAndOutwardThere) {
  const TriangleMesh box = test::box({9, 10, 11}, {14, 12.5, 17});  // padded voxel units
  for (const bool mirrored : {false, true})
    for (const Space space : {Space::lps, Space::ras, Space::voxel}) {
      SCOPED_TRACE(::testing::Message() << mirrored << " " << static_cast<int>(space));
      const Geometry g = oblique(mirrored);
      TriangleMesh mesh = box;
      place_in_space(backend(), g, space, mesh);
      for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
        double along[3], want[3];  // from the centre of voxel (0, 0, 0), along the volume's axes
        for (std::size_t i = 0; i < 3; ++i)
          along[i] = (box.vertices[3 * v + i] - (kPad + 0.5)) * g.spacing[i];
        for (std::size_t i = 0; i < 3; ++i) {
          want[i] = g.origin[i] + g.direction[3 * i] * along[0] +
                    g.direction[3 * i + 1] * along[1] + g.direction[3 * i + 2] * along[2];
          if (space == Space::ras && i < 2) want[i] = -want[i];
          if (space == Space::voxel) want[i] = along[i];
          ASSERT_NEAR(mesh.vertices[3 * v + i], want[i], 1e-6 * std::abs(want[i]) + 1e-6);
        }
      }
      EXPECT_NEAR(measure_quality(backend(), mesh).volume, 5 * 2.5 * 6 * 0.5 * 0.75 * 2, 0.01);
    }
}

INSTANTIATE_TEST_SUITE_P(Backends, BaseSurface, ::testing::ValuesIn(backend_names()), test_name);

}  // namespace
}  // namespace vasamesh
