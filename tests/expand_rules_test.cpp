/// \file
/// Each rule of mesh expanding on a small front in a plane, by hand.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stages/expand_checks.h"
#include "stages/expand_patches.h"
#include "stages/expand_place.h"
#include "stages/expand_propose.h"
#include "stages/expand_rounds.h"
#include "support/analytic_lattice.h"
#include "tbb/backend.h"
#include "types/angles.h"

namespace vasamesh::test {
namespace {

constexpr float kHeight = 8;
constexpr float kRow = 0.8660254f;  // height of a triangle of edge 1

Backend& backend() {
  static const std::shared_ptr<Backend> tbb = make_tbb_backend(2, nullptr);
  return *tbb;
}

/// A plane that faces up, edges of length 1, and loops of the boundary in it: the gap lies to the
/// right of each loop, or outside it where the loop is counter-clockwise.
class ExpandRules : public ::testing::Test {
 protected:
  static const IndicatorField& plane() {
    static const IndicatorField field =
        make_field(backend(),
                   analytic_lattice(backend(), {24, 24, 16}, {1, 1, 1},
                                    [](const Vec3& p) { return kHeight - p.z; }),
                   {24, 24, 16}, {1, 1, 1});
    return field;
  }

  /// Points from the middle of the plane. \return the first corner.
  std::uint32_t add_loop(const std::vector<std::array<float, 2>>& points, float up = 1) {
    const auto first = static_cast<std::uint32_t>(front_.vertex.size());
    for (const auto& [x, y] : points)
      front_.add_corner(front_.add_vertex({12 + x, 12 + y, kHeight}, {0, 0, up}, 1));
    const auto count = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t i = 0; i < count; ++i) front_.link(first + i, first + (i + 1) % count);
    return first;
  }

  Proposal ask(std::uint32_t corner, const FrontLimits& limits = {}) {
    for (const std::uint32_t c : front_.alive)
      front_.angle[c] = angle_between(front_.at(c), front_.normal_at(c),
                                      front_.at(front_.previous[c]), front_.at(front_.next[c]));
    EdgeGrid grid(plane().view());
    grid.build(backend(), front_);
    VertexGrid vertices(plane().view());
    vertices.update(front_);
    ProposalScratch scratch;
    front_.wide[corner] = wide_;
    return propose(plane().view(), sizes(), front_, grid, vertices, limits,
                   claimed_cells(plane().view(), front_, corner), corner, scratch);
  }

  static SizeView sizes() { return {{}, {}, 1}; }  // no bricks: the same size everywhere

  Front front_;
  std::uint8_t wide_ = 1;
};

TEST_F(ExpandRules, AnglesAreThoseOfTheLibrary) {
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

TEST_F(ExpandRules, AGapOfThreeIsClosed) {
  const std::uint32_t c = add_loop({{0, 0}, {0.5f, kRow}, {1, 0}});  // clockwise: a gap
  EXPECT_EQ(ask(c).kind, Proposal::ear);
}

TEST_F(ExpandRules, ATriangleIsNotClosedFromItsOtherSide) {
  const std::uint32_t c = add_loop({{0, 0}, {1, 0}, {0.5f, kRow}});
  EXPECT_NE(ask(c).kind, Proposal::ear);
}

TEST_F(ExpandRules, ANarrowCornerIsCutOff) {
  const std::uint32_t c = add_loop({{0, 0}, {0.5f, kRow}, {1.5f, kRow}, {1, 0}});  // 60 at c
  EXPECT_EQ(ask(c).kind, Proposal::ear);
  EXPECT_EQ(ask(c + 2).kind, Proposal::ear);
}

TEST_F(ExpandRules, AStraightCornerGetsThreeParts) {
  const std::uint32_t c =
      add_loop({{-2, -1}, {2, -1}, {2, 0}, {1, 0}, {0, 0}, {-1, 0}, {-2, 0}}) + 4;
  const Proposal p = ask(c);
  ASSERT_EQ(p.kind, Proposal::fan);
  ASSERT_EQ(p.vertices, 2);
  EXPECT_NEAR(norm(p.position[0] - Vec3{11.5f, 12 + kRow, kHeight}), 0, 1e-3);
  EXPECT_NEAR(norm(p.position[1] - Vec3{12.5f, 12 + kRow, kHeight}), 0, 1e-3);
  EXPECT_NEAR(p.normal[0].z, 1, 1e-5);
}

TEST_F(ExpandRules, TheTipOfATriangleGetsFiveParts) {
  const std::uint32_t c = add_loop({{0, 0}, {1, 0}, {0.5f, kRow}});  // 300 degrees are open
  const Proposal p = ask(c);
  ASSERT_EQ(p.kind, Proposal::fan);
  EXPECT_EQ(p.vertices, 4);
}

/// Two straight fronts, a row of triangles apart.
TEST_F(ExpandRules, AcrossAGapOfOneRowItJoins) {
  const std::uint32_t c =
      add_loop({{2, -1}, {2, 0}, {1, 0}, {0, 0}, {-1, 0}, {-2, 0}, {-2, -1}}) + 3;
  add_loop({{-2, 2}, {-1.5f, kRow}, {-0.5f, kRow}, {0.5f, kRow}, {1.5f, kRow}, {2, 2}});
  const Proposal p = ask(c);
  ASSERT_TRUE(p.kind == Proposal::join_next || p.kind == Proposal::join_previous);
  EXPECT_NEAR(std::fabs(front_.at(p.target).x - 12), 0.5f, 1e-5);
  EXPECT_NEAR(front_.at(p.target).y, 12 + kRow, 1e-5);
}

TEST_F(ExpandRules, AnotherSheetIsNotJoined) {
  const std::uint32_t c =
      add_loop({{2, -1}, {2, 0}, {1, 0}, {0, 0}, {-1, 0}, {-2, 0}, {-2, -1}}) + 3;
  add_loop({{-2, 2}, {-1.5f, kRow}, {-0.5f, kRow}, {0.5f, kRow}, {1.5f, kRow}, {2, 2}}, -1);
  EXPECT_EQ(ask(c).kind, Proposal::fan);
}

/// A front of edges of 1 ahead: new vertices would lie 0.23 or 0.43 from it. A third of an edge is
/// asked for.
TEST_F(ExpandRules, NothingIsPutNearerThanAThirdOfAnEdge) {
  for (const auto& [ahead, kind] :
       {std::pair{1.1f, Proposal::nothing}, std::pair{1.3f, Proposal::fan}}) {
    front_ = {};
    const std::uint32_t c =
        add_loop({{2, -1}, {2, 0}, {1, 0}, {0, 0}, {-1, 0}, {-2, 0}, {-2, -1}}) + 3;
    add_loop({{-2, 3}, {-2, ahead}, {-1, ahead}, {0, ahead}, {1, ahead}, {2, ahead}, {2, 3}});
    FrontLimits no_joins;
    no_joins.join_reach = 0.1f;
    EXPECT_EQ(ask(c, no_joins).kind, kind) << ahead;
  }
}

/// The other front's links may belong to another claim: more room is asked for first.
TEST_F(ExpandRules, WhatIsNotClaimedIsNotChanged) {
  const std::uint32_t c =
      add_loop({{2, -1}, {2, 0}, {1, 0}, {0, 0}, {-1, 0}, {-2, 0}, {-2, -1}}) + 3;
  add_loop({{-2, 2}, {-0.2f, 1}, {6, 1.4f}, {6, 2}});
  wide_ = 0;
  EXPECT_EQ(ask(c, {1.0f, 0.3f, 0.3f, 0.2f}).kind, Proposal::more_room);
}

TEST_F(ExpandRules, TriangleChecks) {
  const Triangle t = {Vec3{0, 0, 0}, Vec3{2, 0, 0}, Vec3{0, 1, 0}};
  EXPECT_FLOAT_EQ(edge_ratio(t), 1 / std::sqrt(5.0f));
  EXPECT_FLOAT_EQ(longest_edge(t), std::sqrt(5.0f));
  const Vec3 up = {0, 0, 1}, aside = {1, 0, 0};
  EXPECT_TRUE(faces_outward(t, {up, up, up}));
  EXPECT_FALSE(faces_outward(t, {up, up, aside}));
  EXPECT_FALSE(faces_outward({t[0], t[2], t[1]}, {up, up, up}));
  EXPECT_FLOAT_EQ(squared_distance({3, 1, 0}, t[0], t[1]), 2);
  EXPECT_FLOAT_EQ(squared_distance({1, 1, 1}, t[0], t[1]), 2);
}

TEST_F(ExpandRules, EdgesThroughTriangles) {
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

TEST_F(ExpandRules, EdgesKeepToTheSurface) {
  const FieldView field = plane().view();
  EXPECT_TRUE(edge_on_surface(field, {8, 8, kHeight}, {9, 8, kHeight}, 0.2f));
  EXPECT_TRUE(edge_on_surface(field, {8, 8, kHeight}, {9, 8, kHeight + 0.3f}, 0.2f));
  EXPECT_FALSE(edge_on_surface(field, {8, 8, kHeight}, {9, 8, kHeight + 0.5f}, 0.2f));
  EXPECT_FALSE(edge_on_surface(field, {8, 8, kHeight}, {8, 8, kHeight + 0.3f}, 0.2f));
}

TEST_F(ExpandRules, PlacesAtTheirDistanceRoundASharpBend) {
  const AnalyticScene tube(backend(), {24, 16, 16}, capsule({4, 8, 8}, {20, 8, 8}, 1.2f));
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
TEST_F(ExpandRules, OneTriangleGrowsToALattice) {
  add_loop({{0, 0}, {1, 0}, {0.5f, kRow}});
  front_.triangles = {0, 1, 2};
  FrontRounds rounds(backend(), plane().view(), sizes(), front_, 100000);
  EXPECT_TRUE(rounds.run({}));
  EXPECT_GT(front_.triangles.size() / 3, 300u);
  for (std::size_t t = 0; t < front_.triangles.size(); t += 3) {
    const std::uint32_t* v = &front_.triangles[t];
    EXPECT_GT(edge_ratio({front_.position[v[0]], front_.position[v[1]], front_.position[v[2]]}),
              0.98f);
  }
}

TEST_F(ExpandRules, PatchesThatTouchAtAVertexKeepTheirGapsApart) {
  // Two triangles that meet at the vertex in the middle.
  TriangleMesh patches;
  for (const auto& [x, y] :
       {std::array{0.0f, 0.0f}, {1, -0.5f}, {1, 0.5f}, {-1, 0.5f}, {-1, -0.5f}})
    patches.vertices.insert(patches.vertices.end(), {12 + x, 12 + y, kHeight});
  patches.triangles = {0, 1, 2, 0, 3, 4};
  const Front front = take_patches(backend(), plane().view(), sizes(), patches);
  ASSERT_EQ(front.vertex.size(), 6u);
  for (std::uint32_t c = 0; c < 6; ++c) {
    EXPECT_EQ(front.previous[front.next[c]], c);
    if (front.vertex[c] != 0) continue;
    // What ends at the middle goes on to the other triangle: the open side is the narrow one.
    const bool right = front.vertex[front.previous[c]] <= 2;
    EXPECT_EQ(front.vertex[front.next[c]] <= 2, !right);
  }
  const FrontResult result = give_result(front);
  EXPECT_EQ(result.mesh.vertices, patches.vertices);
  EXPECT_EQ(result.mesh.triangles, patches.triangles);
  EXPECT_EQ(result.loops.vertex.size(), 6u);
}

}  // namespace
}  // namespace vasamesh::test
