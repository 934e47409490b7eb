/// \file
/// That work of one thread asks whether it is to stop: counted in checkpoints, not in time.

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "backend/in_steps.h"
#include "stages/adjacency.h"
#include "stages/patch_clearance.h"
#include "stages/patch_crowding.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"
#include "stages/quality.h"
#include "stages/relax.h"
#include "stages/triangle_tree.h"
#include "support/analytic_field.h"
#include "support/shapes.h"
#include "tbb/backend.h"
#include "types/mesh_vertex.h"

namespace vasamesh::test {
namespace {

struct Stopped {};

/// A backend of one thread whose checkpoints are counted, and stop the work from one of them on.
class Checkpoints : public ::testing::Test {
 protected:
  Checkpoints() {
    backend_->set_checkpoint([this] {
      if (++asked_ == stop_at_) throw Stopped();
    });
  }

  /// Checkpoints of work that is done; then that each of the first, a middle and the last ends it.
  int asked_by(const std::function<void()>& work) {
    stop_at_ = 0, asked_ = 0;
    work();
    const int all = asked_;
    for (const int at : {1, (all + 1) / 2, all}) {
      if (all == 0) break;
      stop_at_ = at, asked_ = 0;
      EXPECT_THROW(work(), Stopped) << "at " << at << " of " << all;
    }
    stop_at_ = 0;
    return all;
  }

  /// Icosahedra in a row, as one part: what lone voxels are remeshed as.
  PatchMesh specks(std::uint32_t count) const {
    const TriangleMesh one = sphere(0.5f, 0);
    std::vector<SurfacePoint> points;
    std::vector<std::uint32_t> corners;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto first = static_cast<std::uint32_t>(points.size());
      for (const std::uint32_t v : one.triangles) corners.push_back(first + v);
      for (std::size_t v = 0; v < one.vertex_count(); ++v) {
        const Vec3 p = vertex_at(one, v);
        points.push_back({p + Vec3{8 + 2 * static_cast<float>(i), 8, 8}, normalised(p), 0.4f});
        points.back().on_field = false;
      }
    }
    PatchMesh part;
    std::vector<std::uint8_t> whole(points.size(), 1);
    part.build(std::move(points), corners, std::move(whole));
    part.set_backend(backend_.get());
    return part;
  }

  const std::shared_ptr<Backend> backend_ = make_tbb_backend(1, nullptr);
  AnalyticField field_ = plane_field(16, 8);
  int asked_ = 0, stop_at_ = 0;
};

TEST_F(Checkpoints, InPartsOfManySmallShells) {
  constexpr std::uint32_t kShells = 400;
  constexpr int kVertices = 12 * kShells, kLeast = kVertices / 64;
  const PatchMesh before = specks(kShells);
  const RemeshGoal goal = {field_.view(), field_.sizes(0.4f), nullptr, false};
  Relaxer relaxer(*backend_, goal);
  const std::pair<const char*, std::function<void(PatchMesh&)>> passes[] = {
      {"split", [&](PatchMesh& part) { split_long_edges(part, goal, kLongest); }},
      {"collapse", [](PatchMesh& part) { collapse_short_edges(part, kShortest, kLongest); }},
      {"valence", [](PatchMesh& part) { flip_to_valence(part, 1); }},
      {"angle", [](PatchMesh& part) { flip_to_angle(part, 1); }},
      {"repair", [&](PatchMesh& part) { repair(part, goal, kSquaredSine40, 1); }},
      {"even", [](PatchMesh& part) { even_edges(part, 1); }},
      {"widen", [](PatchMesh& part) { widen_angles(part, 1); }},
      {"dihedrals", [](PatchMesh& part) { open_dihedrals(part, 1); }},
      {"crowding", [](PatchMesh& part) { crowded_vertices(part); }},
      {"clearance", [](PatchMesh& part) { Clearance{part}; }},
      {"smooth", [&](PatchMesh& part) { relaxer.smooth(std::array{&part}, 1); }},
      {"equalise", [&](PatchMesh& part) { relaxer.equalise(std::array{&part}, 1); }},
      {"fit", [&](PatchMesh& part) { relaxer.fit(std::array{&part}, 1); }},
  };
  for (const auto& [name, pass] : passes) {
    SCOPED_TRACE(name);
    EXPECT_GE(asked_by([&] {
                PatchMesh part = before;
                pass(part);
              }),
              kLeast);
  }
}

/// Triangles far more than a step has turns.
TriangleMesh large_mesh(std::size_t triangles) {
  TriangleMesh mesh;
  for (std::size_t v = 0; v < triangles + 2; ++v) {
    const auto x = static_cast<float>(v);
    mesh.vertices.insert(mesh.vertices.end(), {x, v % 2 == 0 ? 0.0f : 1.0f, 0.25f * x});
  }
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const std::uint32_t odd = t % 2;
    mesh.triangles.insert(mesh.triangles.end(), {t, t + 1 + odd, t + 2 - odd});
  }
  return mesh;
}

TEST_F(Checkpoints, InSerialWorkOnLargeSurfaces) {
  constexpr int kSteps = 5;
  const TriangleMesh mesh = large_mesh(kSteps * kStepTurns);
  EXPECT_GE(asked_by([&] { vertex_corners(*backend_, mesh); }), 7 * kSteps);
  EXPECT_GE(asked_by([&] { build_triangle_tree(*backend_, mesh); }), 8 * kSteps);
  EXPECT_GE(asked_by([&] { build_tree_in_order(*backend_, mesh); }), kSteps);
  EXPECT_GE(asked_by([&] { describe(*backend_, mesh.vertices); }), 12 * kSteps);
}

TEST_F(Checkpoints, StepsDoWhatOneLoopDoes) {
  const std::size_t count = 3 * kStepTurns + 17;
  std::vector<std::size_t> visited;
  EXPECT_EQ(asked_by([&] {
              visited.clear();
              in_steps(*backend_, count, [&](std::size_t i) { visited.push_back(i); });
            }),
            4);
  in_steps(*backend_, 0, [](std::size_t) { ADD_FAILURE(); });
  visited.clear();
  in_steps(*backend_, count, [&](std::size_t i) { visited.push_back(i); });
  std::vector<std::size_t> all(count);
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(visited, all);

  const std::size_t large = 2 * kStepBytes / sizeof(int) + 5;
  std::vector<int> values = {1, 2, 3}, wanted = values;
  const std::vector<int> more(large, 4);
  EXPECT_GE(asked_by([&] {
              std::vector<int> longer = values;
              append_in_steps<int>(*backend_, more, longer);
            }),
            3);
  append_in_steps<int>(*backend_, more, values);
  wanted.insert(wanted.end(), more.begin(), more.end());
  EXPECT_EQ(values, wanted);
  for (const std::size_t size : {2 * large, large, std::size_t{2}, std::size_t{0}}) {
    resize_in_steps(*backend_, size, values, 7);
    wanted.resize(size, 7);
    EXPECT_EQ(values, wanted);
  }
  EXPECT_EQ(filled_in_steps(*backend_, 5, 2.5f), std::vector<float>(5, 2.5f));
}

}  // namespace
}  // namespace vasamesh::test
