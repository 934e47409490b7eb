/// \file
/// Smoothing and moves towards equal edges of all parts at once, on every backend, against one
/// vertex after the other.

#include "stages/relax.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "reference/relax_reference.h"
#include "stages/hard.h"
#include "stages/mesh_parts.h"
#include "stages/patch_blocks.h"
#include "stages/patch_crowding.h"
#include "stages/places.h"
#include "stages/sizing.h"
#include "support/analytic_lattice.h"
#include "support/backend_test.h"
#include "support/host_backend.h"

namespace vasamesh::test {
namespace {

/// A tree's base surface, its vertices shaken, with a hole where it is cut.
class Scene {
 public:
  explicit Scene(float shake)
      : scene_(host(), {32, 32, 32}, random_tree(5, 3, 32)), mesh_(scene_.surface) {
    sizes_ = make_sizes(host(), scene_.field, scene_.surface, {});
    std::mt19937 random(3);
    for (float& x : mesh_.vertices)
      x += shake * (static_cast<float>(random() % 2001) / 1000.0f - 1.0f);
    std::vector<std::uint8_t> within(mesh_.vertex_count());
    for (std::size_t v = 0; v < within.size(); ++v) within[v] = mesh_.vertices[3 * v] < 20;
    mesh_ = part_of(host(), mesh_, choose_triangles(host(), mesh_, within));
  }

  RemeshGoal goal(const Places* places) const {
    return {scene_.field.view(), sizes_.view(scene_.field), places};
  }
  /// With edges of about the sizes, and vertices that are gone.
  WorkingSurface surface(const RemeshGoal& goal) const {
    WorkingSurface surface = make_working_surface(host(), goal, mesh_);
    for (std::size_t v = 0; v < surface.points.size(); v += 7) surface.points[v].drift = 0.25f;
    for_each_block(host(), {16, 0.5f}, surface,
                   [](PatchMesh& part) { collapse_short_edges(part, kShortest, kLongest); });
    return surface;
  }

 private:
  AnalyticScene scene_;
  SizeField sizes_;
  TriangleMesh mesh_;
};

/// Parts of a surface in which some vertices have been merged into others.
struct Parts {
  Parts(WorkingSurface given, float side)
      : surface(std::move(given)), blocks(host(), {side, 0.3f}, surface), parts(blocks.parts()) {
    for (PatchMesh* part : parts) collapse_short_edges(*part, 0.9f, kLongest);
  }
  WorkingSurface surface;
  SurfaceBlocks blocks;
  std::vector<PatchMesh*> parts;
};

bool same(const SurfacePoint& a, const SurfacePoint& b) {
  return a.position == b.position && a.normal == b.normal && a.size == b.size &&
         a.drift == b.drift && a.on_field == b.on_field;
}

class Relaxation : public BackendTest {
 protected:
  /// All parts at once as each vertex after the other. \return how often one moves.
  int expect_as_one_by_one(const Scene& scene, const Places* places, float side) {
    const RemeshGoal goal = scene.goal(places);
    Parts got(scene.surface(goal), side), want(scene.surface(goal), side);
    Relaxer relaxer(backend(), goal);
    int moves = 0;
    for (const bool equal : {false, true, false}) {
      for (Parts* parts : {&got, &want})
        for (PatchMesh* part : parts->parts) claim_field(*part);
      if (equal)
        relaxer.equalise(got.parts, 3);
      else
        relaxer.smooth(got.parts, 2);
      for (PatchMesh* part : want.parts)
        moves += equal ? equalise_one_by_one(*part, goal, 3) : smooth_one_by_one(*part, goal, 2);
      expect_same(got, want);
    }
    return moves;
  }

  static void expect_same(const Parts& got, const Parts& want) {
    ASSERT_EQ(got.parts.size(), want.parts.size());
    for (std::size_t p = 0; p < got.parts.size(); ++p) {
      ASSERT_EQ(got.parts[p]->points.size(), want.parts[p]->points.size());
      for (std::size_t v = 0; v < got.parts[p]->points.size(); ++v)
        ASSERT_TRUE(same(got.parts[p]->points[v], want.parts[p]->points[v]))
            << "vertex " << v << " of part " << p;
    }
  }

  /// So that the passes have to do with every vertex.
  static void claim_field(PatchMesh& part) {
    for (SurfacePoint& point : part.points) point.on_field = true;
  }
};

TEST_P(Relaxation, OfManyPartsAsOneByOne) {
  EXPECT_GT(expect_as_one_by_one(Scene(0.05f), nullptr, 12), 1000);
}

TEST_P(Relaxation, OfOnePartWithPlacesAndAlmostNothingOnTheSurface) {
  const Places places(std::array<CarefulPlace, 3>{
      {{{10, 14, 15}, 6, 0.5f}, {{12, 16, 17}, 9, 0.7f}, {{15, 12, 12}, 5, 1.3f}}});
  EXPECT_GT(expect_as_one_by_one(Scene(0.3f), &places, 64), 300);
}

TEST_P(Relaxation, FitMovesAlongNormalsByTheGapsAsOnTheHost) {
  const Scene scene(0.02f);
  const RemeshGoal goal = scene.goal(nullptr);
  Parts got(scene.surface(goal), 12), want(scene.surface(goal), 12);
  const Parts before(scene.surface(goal), 12);
  Relaxer(backend(), goal).fit(got.parts, 0);
  Relaxer(host(), goal).fit(want.parts, 0);
  expect_same(got, want);
  int moved = 0;
  for (std::size_t p = 0; p < got.parts.size(); ++p) {
    const std::vector<float> gaps = gaps_one_by_one(*before.parts[p], goal.field);
    for (std::size_t v = 0; v < gaps.size(); ++v) {
      const SurfacePoint& old = before.parts[p]->points[v];
      const Vec3 place = got.parts[p]->points[v].position;
      if (place == old.position) continue;
      const float most = 0.2f * old.size;
      EXPECT_EQ(place, old.position + std::clamp(gaps[v], -most, most) * old.normal);
      ++moved;
    }
  }
  EXPECT_GT(moved, 100);
}

/// Vertices near other sheets come after all others, which do not see them move.
TEST_P(Relaxation, FitThenMakesEdgesEqualAcrossNormals) {
  const Scene scene(0.02f);
  const RemeshGoal goal = scene.goal(nullptr);
  Parts got(scene.surface(goal), 12), want(scene.surface(goal), 12);
  std::vector<std::vector<std::uint8_t>> crowded;
  for (std::size_t p = 0; p < got.parts.size(); ++p) {
    claim_field(*got.parts[p]);
    claim_field(*want.parts[p]);
    crowded.push_back(crowded_vertices(*want.parts[p]));
  }
  Relaxer(backend(), goal).fit(got.parts, 3);
  Relaxer(host(), goal).fit(want.parts, 0);
  int moves = 0, compared = 0;
  for (std::size_t p = 0; p < got.parts.size(); ++p) {
    PatchMesh& part = *want.parts[p];
    for (std::uint32_t v = 0; v < part.vertex_count(); ++v)
      part.points[v].on_field = !crowded[p][v];
    moves += equalise_one_by_one(part, goal, 3, false);
    for (std::uint32_t v = 0; v < part.vertex_count(); ++v) {
      if (crowded[p][v] || !part.is_there(v) || !part.is_inner(v)) continue;
      EXPECT_EQ(got.parts[p]->points[v].position, part.points[v].position);
      EXPECT_FALSE(got.parts[p]->points[v].on_field);
      ++compared;
    }
  }
  EXPECT_GT(moves, 100);
  EXPECT_GT(compared, 100);
}

TEST_P(Relaxation, OfNothing) {
  const Scene scene(0);
  const RemeshGoal goal = scene.goal(nullptr);
  Relaxer relaxer(backend(), goal);
  relaxer.smooth({}, 2);
  PatchMesh empty;
  empty.build({}, {}, {});
  PatchMesh* parts[] = {&empty};
  relaxer.equalise(parts, 2);
  relaxer.fit(parts, 2);
  EXPECT_EQ(empty.vertex_count(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Backends, Relaxation, ::testing::ValuesIn(backend_names()), test_name);

}  // namespace
}  // namespace vasamesh::test
