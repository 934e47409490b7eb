/// \file
/// The proof of a surface: clean meshes pass, and each broken one is told from them by exactly the
/// defect that it has.

#include "stages/verify.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/broken_meshes.h"
#include "support/dense_volume.h"
#include "support/invariants.h"
#include "support/shapes.h"
#include "tbb/backend.h"
#include "vasamesh/errors.h"

namespace vasamesh::test {

/// Tells the numbers in a failure.
void PrintTo(const Defects& d, std::ostream* out) {
  *out << d.open_edges << " open, " << d.nonmanifold_edges << " nonmanifold, "
       << d.misoriented_edges << " misoriented edges, " << d.nonmanifold_vertices
       << " nonmanifold, " << d.isolated_vertices << " isolated, " << d.nonfinite_vertices
       << " not finite vertices, " << d.degenerate_triangles << " degenerate, "
       << d.intersecting_pairs << " pairs, " << d.inverted_shells << " inverted";
}

namespace {

TEST(Verify, CleanSurfacesPass) {
  expect_good_surface(tetrahedron(), Topology{1, 0, 0});
  expect_good_surface(box({-1, -2, -3}, {4, 5, 6}), Topology{1, 0, 0});
  expect_good_surface(sphere(3, 3), Topology{1, 0, 0});
  expect_good_surface(torus(5, 2, 31, 17), Topology{1, 1, 0});
  expect_good_surface(joined(torus(5, 2, 31, 17), moved(sphere(1, 1), {20, 0, 0})),
                      Topology{2, 1, 0});
}

TEST(Verify, NestedShellsAlternate) {
  const TriangleMesh hollow = joined(turned_inside_out(sphere(2, 2)), sphere(3, 2));
  expect_good_surface(hollow, Topology{1, 0, 1});
  expect_good_surface(joined(sphere(1, 1), hollow), Topology{2, 0, 1});
  const CheckReport wrong = check(joined(turned_inside_out(sphere(1, 1)), hollow));
  EXPECT_EQ(wrong.inverted_shells, 1);
}

/// Boxes whose corners and edges line up along x: every ray of the nesting test starts on others'
/// edges, seen along x.
TEST(Verify, NestingOfAlignedBoxes) {
  TriangleMesh mesh = turned_inside_out(box({1, 1, 1}, {9, 9, 9}));
  mesh = joined(mesh, box({0, 0, 0}, {10, 10, 10}));
  for (float x : {2.0f, 4.0f, 6.0f}) mesh = joined(mesh, box({x, 2, 2}, {x + 1, 4, 4}));
  mesh = joined(mesh, box({12, 2, 2}, {13, 4, 4}));
  expect_good_surface(mesh, Topology{5, 0, 1});
}

TEST(Verify, GenusOfEachShell) {
  const TriangleMesh mesh = joined(
      sphere(1, 1), joined(moved(torus(5, 2, 20, 9), {20, 0, 0}), moved(sphere(1, 0), {40, 0, 0})));
  EXPECT_EQ(check(mesh).shell_genus, (std::vector<std::int64_t>{0, 1, 0}));
}

TEST(Verify, TellsEachBadJoin) {
  for (const BrokenMesh& broken : badly_joined_meshes()) {
    SCOPED_TRACE(broken.name);
    const CheckReport report = check(broken.mesh);
    EXPECT_EQ(defects_of(report), broken.defects);
    EXPECT_FALSE(report.passed);
    EXPECT_FALSE(report.reason.empty());
    EXPECT_EQ(report.reason.find('\n'), std::string::npos);
  }
}

TEST(Verify, TellsEachSelfIntersection) {
  for (const NamedMesh& broken : self_intersecting_meshes()) {
    SCOPED_TRACE(broken.name);
    const CheckReport report = check(broken.mesh);
    EXPECT_GT(report.intersecting_pairs, 0);
    Defects only_pairs;
    only_pairs.intersecting_pairs = report.intersecting_pairs;
    EXPECT_EQ(defects_of(report), only_pairs);
    EXPECT_FALSE(report.passed);
  }
}

TEST(Verify, TheReasonCountsOneAsOne) {
  EXPECT_EQ(check(turned_inside_out(tetrahedron())).reason, "1 shell facing the wrong way");
  TriangleMesh mesh = tetrahedron();
  add_triangle(mesh, 0, 0, 1);
  EXPECT_EQ(check(mesh).reason, "1 degenerate triangle");
  add_vertex(mesh, {5, 5, 5});
  add_vertex(mesh, {6, 5, 5});
  EXPECT_EQ(check(mesh).reason, "2 vertices of no triangle, 1 degenerate triangle");
}

/// Half inside another, a shell has no way to face.
TEST(Verify, IntersectingShellsAreNotCalledInverted) {
  int inverted = 0;
  for (const float x : {-2.0f, 2.0f}) {
    const CheckReport report = check(joined(sphere(2, 2), moved(sphere(1, 1), {x, 0, 0})));
    EXPECT_GT(report.intersecting_pairs, 1);
    EXPECT_EQ(report.reason,
              std::to_string(report.intersecting_pairs) + " intersecting pairs of triangles");
    inverted += report.inverted_shells > 0;
  }
  EXPECT_GT(inverted, 0);
}

/// A fan of more triangles than are searched plainly, whole and then with a gap.
TEST(Verify, LargeFans) {
  TriangleMesh mesh;
  const int n = 101;
  for (int i = 0; i < n; ++i)
    add_vertex(mesh, {std::cos(0.0622f * static_cast<float>(i)),
                      std::sin(0.0622f * static_cast<float>(i)), 0});
  const std::uint32_t top = add_vertex(mesh, {0, 0, 1}), bottom = add_vertex(mesh, {0, 0, -1});
  for (std::uint32_t i = 0; i < n; ++i) {
    add_triangle(mesh, i, (i + 1) % n, top);
    add_triangle(mesh, (i + 1) % n, i, bottom);
  }
  expect_good_surface(mesh, Topology{1, 0, 0});
  mesh.triangles.erase(mesh.triangles.begin() + 60, mesh.triangles.begin() + 63);
  EXPECT_EQ(defects_of(check(mesh)), (Defects{.open_edges = 3}));
  mesh.triangles.erase(mesh.triangles.begin() + 243, mesh.triangles.begin() + 246);
  const CheckReport two_gaps = check(mesh);
  EXPECT_EQ(two_gaps.open_edges, 6);
  EXPECT_EQ(two_gaps.nonmanifold_vertices, 1);
}

TEST(Verify, EmptySurfaceFails) {
  const CheckReport report = check({});
  EXPECT_FALSE(report.passed);
  EXPECT_EQ(report.reason, "no triangles");
}

TEST(Verify, IndexOutOfRangeIsBadInput) {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles[4] = 4;
  try {
    check(mesh);
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_NE(std::string(error.what()).find("triangle 1 names vertex 4"), std::string::npos);
  }
}

TEST(Verify, SameReportForAnyNumberOfThreads) {
  TriangleMesh mesh = joined(torus(5, 2, 200, 80), moved(torus(5, 2, 150, 70), {3, 0, 1}));
  const CheckReport two = check_surface(*make_tbb_backend(2, nullptr), mesh, nullptr);
  const CheckReport one = check_surface(*make_tbb_backend(1, nullptr), mesh, nullptr);
  EXPECT_GT(one.intersecting_pairs, 0);
  EXPECT_EQ(one.reason, two.reason);
}

/// Surfaces against segmentations: a ball, a ring and a hollow ball of voxels in one volume.
class VerifyAgainstVolume : public testing::Test {
 protected:
  static constexpr Vertex kBall{10, 10, 10}, kRing{30, 12, 10}, kHollow{55, 12, 12};

  static DenseVolume make_volume() {
    DenseVolume volume({70, 26, 26});
    for (int z = 0; z < 26; ++z)
      for (int y = 0; y < 26; ++y)
        for (int x = 0; x < 70; ++x) volume.at(x, y, z) = inside(x, y, z);
    return volume;
  }

  static bool inside(int x, int y, int z) {
    const auto distance = [](const Vertex& c, int i, int j, int k) {
      return std::hypot(static_cast<float>(i) - c[0], static_cast<float>(j) - c[1],
                        static_cast<float>(k) - c[2]);
    };
    if (distance(kBall, x, y, z) <= 4) return true;
    const float hollow = distance(kHollow, x, y, z);
    if (hollow >= 4 && hollow <= 9) return true;
    const float ring =
        std::hypot(static_cast<float>(x) - kRing[0], static_cast<float>(y) - kRing[1]) - 8;
    return std::hypot(ring, static_cast<float>(z) - kRing[2]) <= 2.5f;
  }

  static TriangleMesh ball() { return moved(sphere(4.2f, 2), kBall); }
  static TriangleMesh ring() { return moved(torus(8, 2.7f, 40, 16), kRing); }
  static TriangleMesh shell() { return moved(sphere(9.2f, 3), kHollow); }
  static TriangleMesh cavity() { return moved(turned_inside_out(sphere(3.8f, 2)), kHollow); }
  static TriangleMesh all() { return joined(joined(ball(), ring()), joined(shell(), cavity())); }

  CheckReport match(const TriangleMesh& mesh, Space space = Space::lps) {
    const auto backend = make_tbb_backend(2, nullptr);
    const BitVolume bits = pack_plainly(*backend, volume_);
    const Solid solid =
        examine_solid(*backend, bits.view(), volume_.size64(), Connectivity::vertex);
    const SolidMatch wanted{&solid, geometry_, space};
    return check_surface(*backend, mesh, &wanted);
  }

  /// The mesh, whose vertices are voxel indices, in the given space.
  TriangleMesh placed(TriangleMesh mesh, Space space) const {
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      float* p = mesh.vertices.data() + 3 * v;
      std::array<double, 3> along, x = geometry_.origin;
      for (int a = 0; a < 3; ++a) along[a] = geometry_.spacing[a] * p[a];
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) x[a] += geometry_.direction[3 * a + b] * along[b];
      if (space == Space::voxel) x = along;
      if (space == Space::ras) x = {-x[0], -x[1], x[2]};
      for (int a = 0; a < 3; ++a) p[a] = static_cast<float>(x[a]);
    }
    return mesh;
  }

  DenseVolume volume_ = make_volume();
  Geometry geometry_ = volume_.view().geometry;
};

TEST_F(VerifyAgainstVolume, RightSurfacePasses) {
  const CheckReport report = match(all());
  EXPECT_TRUE(report.passed) << report.reason;
  EXPECT_TRUE(report.has_wanted);
  EXPECT_EQ(report.wanted.handles, 1);
  EXPECT_EQ(report.wanted.cavities, 1);
  EXPECT_EQ(report.wanted.pieces, 3);
}

TEST_F(VerifyAgainstVolume, InEverySpace) {
  geometry_.spacing = {0.5, 0.75, 1.5};
  geometry_.origin = {-100, 40, 7};
  geometry_.direction = {0, -1, 0, 0.6, 0, -0.8, 0.8, 0, 0.6};  // a turn, no mirror
  for (Space space : {Space::lps, Space::ras, Space::voxel}) {
    const CheckReport report = match(placed(all(), space), space);
    EXPECT_TRUE(report.passed) << report.reason;
  }
  EXPECT_EQ(match(placed(all(), Space::lps), Space::ras).mismatched_pieces, 3 + 3);
}

TEST_F(VerifyAgainstVolume, WrongPieces) {
  EXPECT_EQ(match(joined(ball(), joined(shell(), cavity()))).mismatched_pieces, 1);  // no ring
  EXPECT_EQ(match(joined(joined(ball(), ring()), shell())).mismatched_pieces, 1);    // no cavity
  const TriangleMesh stray = moved(sphere(1, 1), {22, 2, 2});
  EXPECT_EQ(match(joined(all(), stray)).mismatched_pieces, 1);
}

/// Two pieces choose the one shell, so that neither has it, and it is far from both.
TEST_F(VerifyAgainstVolume, OneShellRoundTwoPieces) {
  const TriangleMesh round = moved(sphere(19.5f, 3), {21, 12, 10});
  EXPECT_EQ(match(joined(round, joined(shell(), cavity()))).mismatched_pieces, 2 + 1);
}

/// Sums that agree do not hide pieces that differ.
TEST_F(VerifyAgainstVolume, WrongGenusOfPieces) {
  const TriangleMesh ring_at_ball = moved(torus(3, 1, 20, 8), kBall);
  const TriangleMesh ball_at_ring = moved(sphere(2, 2), {38, 12, 10});
  const CheckReport report =
      match(joined(joined(ring_at_ball, ball_at_ring), joined(shell(), cavity())));
  EXPECT_EQ(report.topology, report.wanted);
  EXPECT_EQ(report.mismatched_pieces, 2);
  EXPECT_FALSE(report.passed);
}

}  // namespace
}  // namespace vasamesh::test
