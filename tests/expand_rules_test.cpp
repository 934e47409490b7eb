/// \file
/// Each rule of mesh expanding on a small front in a plane, by hand, on every backend.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "stages/expand_checks.h"
#include "stages/expand_front.h"
#include "stages/expand_patches.h"
#include "stages/expand_place.h"
#include "stages/expand_rounds.h"
#include "support/analytic_lattice.h"
#include "support/backend_test.h"
#include "support/host_backend.h"
#include "types/angles.h"
#include "types/segment.h"

namespace vasamesh::test {
namespace {

constexpr float kHeight = 8;
constexpr float kRow = 0.8660254f;  // height of a triangle of edge 1

/// A plane that faces up, edges of length 1, and loops of the boundary in it: the gap lies to the
/// right of each loop, or outside it where the loop is counter-clockwise.
class ExpandRules : public BackendTest {
 protected:
  static const IndicatorField& plane() {
    static const IndicatorField field =
        make_field(host(),
                   analytic_lattice(host(), {24, 24, 16}, {1, 1, 1},
                                    [](const Vec3& p) { return kHeight - p.z; }),
                   {24, 24, 16}, {1, 1, 1});
    return field;
  }

  void SetUp() override {
    BackendTest::SetUp();
    if (!IsSkipped()) start();
  }

  /// An empty front.
  void start() { front_.emplace(backend(), plane().view()); }

  /// Points from the middle of the plane. \return the first corner.
  std::uint32_t add_loop(const std::vector<std::array<float, 2>>& points, float up = 1) {
    front_->bring_to_host();
    const std::uint32_t first = front_->counts().corners;
    for (const auto& [x, y] : points)
      front_->add_corner(front_->add_vertex({12 + x, 12 + y, kHeight}, {0, 0, up}, 1));
    const auto count = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t i = 0; i < count; ++i) front_->link(first + i, first + (i + 1) % count);
    return first;
  }

  /// What a corner proposes when it alone is chosen.
  Proposal ask(std::uint32_t corner, const FrontLimits& limits = {}) {
    const FieldView field = plane().view();
    backend().expand_choose(field, ++round_, true, front_->view());
    front_->begin_round();
    FrontView view = front_->view();
    backend().on_host(view.corners)[corner].wide = wide_;
    backend().upload<std::uint32_t>(view.chosen.subview(0, 1), {&corner, 1});
    view.proposals = view.proposals.subview(0, 1);
    view.starts = view.starts.subview(0, 1);
    backend().expand_claim(field, view);
    backend().expand_propose(field, sizes(), limits, view);
    return to_host(backend(), view.proposals)[0];
  }

  Vec3 position_of(std::uint32_t corner) {
    front_->bring_to_host();
    return front_->view().position_of(corner);
  }

  static SizeView sizes() { return {{}, {}, 1}; }  // no bricks: the same size everywhere

  std::optional<Front> front_;
  std::uint32_t round_ = 0;
  std::uint8_t wide_ = 1;
};

TEST_P(ExpandRules, AnglesAreThoseOfTheLibrary) {
  for (int i = 0; i < 720; ++i) {
    const double angle = (i + 0.5) * std::numbers::pi / 360;
    const auto x = static_cast<float>(3 * std::cos(angle)),
               y = static_cast<float>(3 * std::sin(angle));
    ASSERT_NEAR(positive_angle(x, y), angle, 1e-4);
  }
  EXPECT_EQ(positive_angle(0, 0), 0);
  for (float angle = -2; angle <= 2; angle += 0.01f) {
    ASSERT_NEAR(rotation_by(angle).cosine, std::cos(angle), 3e-4);
    ASSERT_NEAR(rotation_by(angle).sine, std::sin(angle), 3e-4);
  }
}

TEST_P(ExpandRules, AGapOfThreeIsClosed) {
  const std::uint32_t c = add_loop({{0, 0}, {0.5f, kRow}, {1, 0}});  // clockwise: a gap
  EXPECT_EQ(ask(c).kind, Proposal::ear);
}

TEST_P(ExpandRules, ATriangleIsNotClosedFromItsOtherSide) {
  const std::uint32_t c = add_loop({{0, 0}, {1, 0}, {0.5f, kRow}});
  EXPECT_NE(ask(c).kind, Proposal::ear);
}

TEST_P(ExpandRules, ANarrowCornerIsCutOff) {
  const std::uint32_t c = add_loop({{0, 0}, {0.5f, kRow}, {1.5f, kRow}, {1, 0}});  // 60 at c
  EXPECT_EQ(ask(c).kind, Proposal::ear);
  EXPECT_EQ(ask(c + 2).kind, Proposal::ear);
}

TEST_P(ExpandRules, AStraightCornerGetsThreeParts) {
  const std::uint32_t c =
      add_loop({{-2, -1}, {2, -1}, {2, 0}, {1, 0}, {0, 0}, {-1, 0}, {-2, 0}}) + 4;
  const Proposal p = ask(c);
  ASSERT_EQ(p.kind, Proposal::fan);
  ASSERT_EQ(p.vertices, 2);
  EXPECT_NEAR(norm(p.position[0] - Vec3{11.5f, 12 + kRow, kHeight}), 0, 1e-3);
  EXPECT_NEAR(norm(p.position[1] - Vec3{12.5f, 12 + kRow, kHeight}), 0, 1e-3);
  EXPECT_NEAR(p.normal[0].z, 1, 1e-5);
}

TEST_P(ExpandRules, TheTipOfATriangleGetsFiveParts) {
  const std::uint32_t c = add_loop({{0, 0}, {1, 0}, {0.5f, kRow}});  // 300 degrees are open
  const Proposal p = ask(c);
  ASSERT_EQ(p.kind, Proposal::fan);
  EXPECT_EQ(p.vertices, 4);
}

/// Two straight fronts, a row of triangles apart.
TEST_P(ExpandRules, AcrossAGapOfOneRowItJoins) {
  const std::uint32_t c =
      add_loop({{2, -1}, {2, 0}, {1, 0}, {0, 0}, {-1, 0}, {-2, 0}, {-2, -1}}) + 3;
  add_loop({{-2, 2}, {-1.5f, kRow}, {-0.5f, kRow}, {0.5f, kRow}, {1.5f, kRow}, {2, 2}});
  const Proposal p = ask(c);
  ASSERT_TRUE(p.kind == Proposal::join_next || p.kind == Proposal::join_previous);
  EXPECT_NEAR(std::fabs(position_of(p.target).x - 12), 0.5f, 1e-5);
  EXPECT_NEAR(position_of(p.target).y, 12 + kRow, 1e-5);
}

TEST_P(ExpandRules, AnotherSheetIsNotJoined) {
  const std::uint32_t c =
      add_loop({{2, -1}, {2, 0}, {1, 0}, {0, 0}, {-1, 0}, {-2, 0}, {-2, -1}}) + 3;
  add_loop({{-2, 2}, {-1.5f, kRow}, {-0.5f, kRow}, {0.5f, kRow}, {1.5f, kRow}, {2, 2}}, -1);
  EXPECT_EQ(ask(c).kind, Proposal::fan);
}

/// A front of edges of 1 ahead: new vertices would lie 0.23 or 0.43 from it. A third of an edge is
/// asked for.
TEST_P(ExpandRules, NothingIsPutNearerThanAThirdOfAnEdge) {
  for (const auto& [ahead, kind] :
       {std::pair{1.1f, Proposal::nothing}, std::pair{1.3f, Proposal::fan}}) {
    start();
    const std::uint32_t c =
        add_loop({{2, -1}, {2, 0}, {1, 0}, {0, 0}, {-1, 0}, {-2, 0}, {-2, -1}}) + 3;
    add_loop({{-2, 3}, {-2, ahead}, {-1, ahead}, {0, ahead}, {1, ahead}, {2, ahead}, {2, 3}});
    FrontLimits no_joins;
    no_joins.join_reach = 0.1f;
    EXPECT_EQ(ask(c, no_joins).kind, kind) << ahead;
  }
}

/// The other front's links may belong to another claim: more room is asked for first.
TEST_P(ExpandRules, WhatIsNotClaimedIsNotChanged) {
  const std::uint32_t c =
      add_loop({{2, -1}, {2, 0}, {1, 0}, {0, 0}, {-1, 0}, {-2, 0}, {-2, -1}}) + 3;
  add_loop({{-2, 2}, {-0.2f, 1}, {6, 1.4f}, {6, 2}});
  wide_ = 0;
  EXPECT_EQ(ask(c, {1.0f, 0.3f, 0.3f, 0.2f}).kind, Proposal::more_room);
}

TEST_P(ExpandRules, TriangleChecks) {
  const Triangle t = {Vec3{0, 0, 0}, Vec3{2, 0, 0}, Vec3{0, 1, 0}};
  EXPECT_FLOAT_EQ(edge_ratio(t), 1 / std::sqrt(5.0f));
  EXPECT_FLOAT_EQ(longest_edge(t), std::sqrt(5.0f));
  const Vec3 up = {0, 0, 1}, aside = {1, 0, 0};
  EXPECT_TRUE(faces_outward(t, {up, up, up}));
  EXPECT_FALSE(faces_outward(t, {up, up, aside}));
  EXPECT_FALSE(faces_outward({t[0], t[2], t[1]}, {up, up, up}));
  EXPECT_FLOAT_EQ(squared_to_segment({3, 1, 0}, t[0], t[1]), 2);
  EXPECT_FLOAT_EQ(squared_to_segment({1, 1, 1}, t[0], t[1]), 2);
}

TEST_P(ExpandRules, EdgesThroughTriangles) {
  const Triangle t = {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0.5f, kRow, 0}};
  const Vec3 up = {0, 0, 1};
  const auto crosses = [&](const Vec3& a, const Vec3& b, const Vec3& normal) {
    return edge_crosses({a, b, normal, 0}, t);
  };
  EXPECT_TRUE(crosses({-1, 0.3f, 0}, {2, 0.3f, 0}, up));
  EXPECT_TRUE(crosses({0.5f, 0.3f, 0.1f}, {0.5f, 0.31f, 0.1f}, up));  // within it
  EXPECT_TRUE(crosses({0, 0, 0}, {1, 0.6f, 0}, up));                  // from a corner, through
  EXPECT_FALSE(crosses({0, 0, 0}, {1, 0, 0}, up));                    // along a side
  EXPECT_FALSE(crosses({0.5f, kRow, 0}, {1.5f, kRow, 0}, up));        // from a corner, away
  EXPECT_FALSE(crosses({-1, 0.3f, 0}, {2, 0.3f, 0}, {0, 0, -1}));     // the other side's
  EXPECT_FALSE(crosses({-1, 0.3f, 0.8f}, {2, 0.3f, 0.8f}, up));       // another sheet
}

TEST_P(ExpandRules, EdgesKeepToTheSurface) {
  const FieldView field = plane().view();
  EXPECT_TRUE(edge_on_surface(field, {8, 8, kHeight}, {9, 8, kHeight}, 0.2f));
  EXPECT_TRUE(edge_on_surface(field, {8, 8, kHeight}, {9, 8, kHeight + 0.3f}, 0.2f));
  EXPECT_FALSE(edge_on_surface(field, {8, 8, kHeight}, {9, 8, kHeight + 0.5f}, 0.2f));
  EXPECT_FALSE(edge_on_surface(field, {8, 8, kHeight}, {8, 8, kHeight + 0.3f}, 0.2f));
}

TEST_P(ExpandRules, PlacesAtTheirDistanceRoundASharpBend) {
  const AnalyticScene tube(host(), {24, 16, 16}, capsule({4, 8, 8}, {20, 8, 8}, 1.2f));
  const Vec3 from = {12, 8, 9.2f};
  for (const float length : {0.5f, 1.0f, 1.4f}) {
    Vec3 place, normal;
    ASSERT_TRUE(place_on_surface(tube.field.view(), from, {0, 1, 0}, length, place, normal));
    EXPECT_NEAR(norm(place - from), length, 0.1f * length);
    EXPECT_NEAR(norm(place - Vec3{12, 8, 8}), 1.2f, 0.03f);
    EXPECT_NEAR(place.x, 12, 1e-3);
    EXPECT_GT(dot(normal, place - Vec3{12, 8, 8}), 1.1f);
  }
}

/// From one triangle in a plane the rounds fill it, up to its border, all triangles equilateral.
TEST_P(ExpandRules, OneTriangleGrowsToALattice) {
  add_loop({{0, 0}, {1, 0}, {0.5f, kRow}});
  front_->add_triangle(0, 1, 2);
  FrontRounds rounds(backend(), plane().view(), sizes(), *front_, 100000);
  EXPECT_TRUE(rounds.run({}));
  EXPECT_GT(front_->counts().triangles, 300u);
  front_->bring_to_host();
  const FrontView view = front_->view();
  for (std::size_t t = 0; t < front_->counts().triangles; ++t) {
    Triangle triangle;
    for (std::size_t i = 0; i < 3; ++i)
      triangle[i] = view.vertices[view.triangles[3 * t + i]].position;
    EXPECT_GT(edge_ratio(triangle), 0.98f);
  }
}

TEST_P(ExpandRules, PatchesThatTouchAtAVertexKeepTheirGapsApart) {
  // Two triangles that meet at the vertex in the middle.
  TriangleMesh patches;
  for (const auto& [x, y] :
       {std::array{0.0f, 0.0f}, {1, -0.5f}, {1, 0.5f}, {-1, 0.5f}, {-1, -0.5f}})
    patches.vertices.insert(patches.vertices.end(), {12 + x, 12 + y, kHeight});
  patches.triangles = {0, 1, 2, 0, 3, 4};
  Front front = take_patches(backend(), plane().view(), sizes(), patches);
  ASSERT_EQ(front.counts().corners, 6u);
  const FrontView view = front.view();
  for (std::uint32_t c = 0; c < 6; ++c) {
    const FrontCorner& corner = view.corners[c];
    EXPECT_EQ(view.corners[corner.next].previous, c);
    if (corner.vertex != 0) continue;
    // What ends at the middle goes on to the other triangle: the open side is the narrow one.
    const bool right = view.corners[corner.previous].vertex <= 2;
    EXPECT_EQ(view.corners[corner.next].vertex <= 2, !right);
  }
  const FrontResult result = give_result(front);
  EXPECT_EQ(result.mesh.vertices, patches.vertices);
  EXPECT_EQ(result.mesh.triangles, patches.triangles);
  EXPECT_EQ(result.loops.vertex.size(), 6u);
}

INSTANTIATE_TEST_SUITE_P(Backends, ExpandRules, ::testing::ValuesIn(backend_names()), test_name);

}  // namespace
}  // namespace vasamesh::test
