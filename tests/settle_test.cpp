/// \file
/// Settling: a surface that is damaged in places is near its bounds and well shaped again.

#include "stages/settle.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

#include "stages/quality.h"
#include "stages/remesh.h"
#include "stages/sizing.h"
#include "support/analytic_lattice.h"
#include "support/invariants.h"
#include "tbb/backend.h"
#include "types/mesh_vertex.h"

namespace vasamesh::test {
namespace {

constexpr float kLimit = 0.8f, kRadius = 4;
constexpr std::size_t kEnough = 1000000;

/// A ring, its own base surface and marching cubes.
class SettleTest : public ::testing::Test {
 protected:
  SettleTest() : SettleTest({36, 36, 16}, ring({18, 18, 8}, 11, 3.5f)) {}

  SettleTest(const std::array<int, 3>& size, const Solid3& solid)
      : scene_(*backend_, size, solid),
        sizes_(make_sizes(*backend_, scene_.field, scene_.surface, {})),
        solid_{scene_.surface, scene_.surface},
        tree_(build_triangle_tree(*backend_, scene_.surface)),
        mesh_(remesh(*backend_, scene_.field.view(), sizes_.view(scene_.field), scene_.surface)) {}

  Settled settled(TriangleMesh mesh, Backend& on, std::span<const CarefulPlace> within = {}) const {
    std::size_t work = kEnough;
    return settled(std::move(mesh), on, within, solid_, work);
  }
  Settled settled(TriangleMesh mesh, Backend& on, std::span<const CarefulPlace> within,
                  const SolidSurface& solid, std::size_t& work) const {
    const Bounds bounds = {scene_.surface, tree_, solid, tree_, kLimit};
    return settle(on, scene_.field.view(), sizes_.view(scene_.field), bounds, kRadius,
                  std::move(mesh), within, {}, work);
  }

  /// Marching cubes with a small triangle in the middle of the hole.
  SolidSurface crumbed() const {
    SolidSurface solid = solid_;
    const auto first = static_cast<std::uint32_t>(solid.all.vertex_count());
    solid.all.vertices.insert(solid.all.vertices.end(), {18, 18, 8, 18.2f, 18, 8, 18, 18.2f, 8});
    solid.all.triangles.insert(solid.all.triangles.end(), {first, first + 1, first + 2});
    return solid;
  }

  /// The mesh with its vertices on one side drawn together to a tenth, and one drawn out.
  TriangleMesh damaged() const { return damaged(mesh_, kSpot); }

  static TriangleMesh damaged(TriangleMesh mesh, const Vec3& spot) {
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      const Vec3 from = vertex_at(mesh, v) - spot;
      if (norm(from) > 2.5f) continue;
      for (std::size_t i = 0; i < 3; ++i)
        mesh.vertices[3 * v + i] -= 0.8f * (i == 0 ? from.x : i == 1 ? from.y : from.z);
    }
    return mesh;
  }

  static constexpr Vec3 kSpot{32.5f, 18, 8};
  std::shared_ptr<Backend> backend_ = make_tbb_backend(2, nullptr);
  AnalyticScene scene_;
  SizeField sizes_;
  SolidSurface solid_;
  TriangleTree tree_;
  TriangleMesh mesh_;
};

TEST_F(SettleTest, ADamagedPlaceIsMadeGood) {
  const TriangleMesh mesh = damaged();
  ASSERT_LT(measure_quality(*backend_, mesh).least_angle.minimum, 20);
  const Settled result = settled(mesh, *backend_);
  EXPECT_TRUE(result.far.empty());
  expect_good_surface(result.mesh, Topology{1, 1, 0});
  EXPECT_GE(measure_quality(*backend_, result.mesh).least_angle.minimum, 20);
}

TEST_F(SettleTest, APointThatCannotBeReachedIsReported) {
  std::size_t work = kEnough;
  const Settled result = settled(mesh_, *backend_, {}, crumbed(), work);
  EXPECT_LT(work, kEnough);
  EXPECT_FALSE(result.far.empty());
  expect_good_surface(result.mesh, Topology{1, 1, 0});
}

TEST_F(SettleTest, NoTryBeginsWithoutWork) {
  std::size_t work = 1;
  const Settled result = settled(mesh_, *backend_, {}, crumbed(), work);
  EXPECT_EQ(work, 0u);
  EXPECT_FALSE(result.far.empty());
  expect_good_surface(result.mesh, Topology{1, 1, 0});
}

TEST_F(SettleTest, ElsewhereThanInThePlacesNothingMoves) {
  const CarefulPlace place = {kSpot, kRadius, 1};
  const Settled result = settled(damaged(), *backend_, {&place, 1});
  std::size_t same = 0, away = 0;
  std::set<std::array<float, 3>> there;
  const auto at = [](const TriangleMesh& mesh, std::size_t v) {
    return std::array{mesh.vertices[3 * v], mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]};
  };
  for (std::size_t v = 0; v < result.mesh.vertex_count(); ++v) there.insert(at(result.mesh, v));
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    if (norm(vertex_at(mesh_, v) - kSpot) < 12) continue;
    ++away;
    same += there.count(at(mesh_, v));
  }
  EXPECT_GT(away, 50u);
  EXPECT_EQ(same, away);
}

TEST_F(SettleTest, TheSameBytesOnAnyNumberOfThreads) {
  const TriangleMesh mesh = damaged();
  const TriangleMesh one = settled(mesh, *make_tbb_backend(1, nullptr)).mesh;
  for (const int threads : {2, 4}) {
    const TriangleMesh other = settled(mesh, *make_tbb_backend(threads, nullptr)).mesh;
    EXPECT_EQ(one.vertices, other.vertices);
    EXPECT_EQ(one.triangles, other.triangles);
  }
}

/// A ring that is wide enough for places that are mended at the same time.
class WideSettleTest : public SettleTest {
 protected:
  WideSettleTest() : SettleTest({72, 72, 16}, ring({36, 36, 8}, 28, 3.5f)) {}
};

TEST_F(WideSettleTest, PlacesApartAreMendedTogether) {
  const TriangleMesh mesh = damaged(damaged(mesh_, {67.5f, 36, 8}), {4.5f, 36, 8});
  const Settled one = settled(mesh, *make_tbb_backend(1, nullptr));
  EXPECT_TRUE(one.far.empty());
  expect_good_surface(one.mesh, Topology{1, 1, 0});
  EXPECT_GE(measure_quality(*backend_, one.mesh).least_angle.minimum, 20);
  const Settled two = settled(mesh, *make_tbb_backend(2, nullptr));
  EXPECT_EQ(one.mesh.vertices, two.mesh.vertices);
  EXPECT_EQ(one.mesh.triangles, two.mesh.triangles);
}

}  // namespace
}  // namespace vasamesh::test
