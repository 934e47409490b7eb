/// \file
/// Adaptive surfaces of whole conversions: proven, well shaped, of fewer triangles than marching
/// cubes, of the edge lengths and the number of triangles that are asked for, the same bytes at any
/// number of threads.

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <utility>

#include "backend/backend.h"
#include "io/marching_cubes.h"
#include "support/cases.h"
#include "support/dense_volume.h"
#include "support/invariants.h"
#include "types/mesh_vertex.h"
#include "types/vec3.h"
#include "vasamesh/errors.h"
#include "vasamesh/host.h"
#include "vasamesh/pipeline.h"

namespace vasamesh::test {
namespace {

Context make_threads(int threads) {
  return make_context({.backend = "tbb", .device = "", .threads = threads});
}

Result convert_adaptively(const VolumeView& volume, Parameters parameters, int threads = 2) {
  Context context = make_threads(threads);
  parameters.surface = SurfaceKind::adaptive;
  parameters.space = Space::voxel;
  return convert(volume, parameters, context);
}

Result convert_adaptively(const VolumeView& volume, const EdgeLengths& edges = EdgeLengths()) {
  Parameters parameters;
  parameters.edges = edges;
  return convert_adaptively(volume, parameters);
}

void expect_proven(const Result& result, const VolumeView& volume) {
  expect_good_surface(result.mesh, volume, Connectivity::vertex, Space::voxel);
  EXPECT_TRUE(result.report.check.passed);
  EXPECT_EQ(static_cast<std::size_t>(result.report.check.triangles), result.mesh.triangle_count());
}

/// A phantom and how well its surface is shaped at least.
struct Shaped {
  PhantomCase phantom;
  double share;         ///< of triangles with tau >= 0.8
  double least_angle;   ///< degrees, of all triangles
  double percentile_5;  ///< of the least angles
  double count;         ///< triangles at most, over those of marching cubes
};

void PrintTo(const Shaped& shaped, std::ostream* stream) { *stream << shaped.phantom.label; }

class Phantoms : public ::testing::TestWithParam<Shaped> {};

TEST_P(Phantoms, ProvenAndWellShaped) {
  const Shaped& want = GetParam();
  const Phantom phantom = want.phantom.make();
  const Result result = convert_adaptively(phantom.view());
  expect_proven(result, phantom.view());
  const QualityReport& quality = result.report.quality;
  EXPECT_GE(quality.edge_ratio_above_08, want.share);
  EXPECT_GE(quality.least_angle.minimum, want.least_angle);
  EXPECT_GE(quality.least_angle.percentile_5, want.percentile_5);
  EXPECT_EQ(quality.sharp_edges, 0);
  const double cubes =
      static_cast<double>(marching_cubes({phantom.geometry, phantom.voxels}).triangle_count());
  EXPECT_LE(static_cast<double>(result.mesh.triangle_count()), want.count * cubes);
  EXPECT_EQ(result.report.mesh.base_share, 0);
  EXPECT_EQ(result.report.mesh.far_points, 0);
}

PhantomCase named(const std::string& name) { return {name, name, {}}; }

std::vector<Shaped> shaped_cases() {
  std::vector<Shaped> cases;
  for (const char* name : {"sphere", "torus", "y_branch", "hollow_shell", "two_tubes"})
    cases.push_back({named(name), 0.93, 20, 47, 0.45});
  cases.push_back({named("line_space_diagonal"), 0.8, 25, 42, 0.9});
  cases.push_back({named("one_slice"), 0.68, 18, 38, 1.2});
  cases.push_back({named("single_voxel"), 0.4, 30, 38, 4});
  for (const PhantomCase& tree : tree_cases(4)) cases.push_back({tree, 0.75, 12, 40, 1.2});
  return cases;
}

INSTANTIATE_TEST_SUITE_P(All, Phantoms, ::testing::ValuesIn(shaped_cases()),
                         [](const auto& param_info) { return param_info.param.phantom.label; });

TEST(Adaptive, EdgesTooLongForTheirVesselsAreReported) {
  const Phantom phantom = named("two_tubes").make();
  Parameters parameters;
  parameters.edges.rho = 2;
  parameters.edges.edge_max = 20;
  parameters.edges.gradation = 1;
  const Result result = convert_adaptively(phantom.view(), parameters);
  expect_proven(result, phantom.view());
  EXPECT_GT(result.report.mesh.far_points, 0);
  const std::array<double, 3>& spacing = phantom.geometry.spacing;
  EXPECT_NEAR(result.report.distance_limit,
              std::max(*std::min_element(spacing.begin(), spacing.end()),
                       0.55 * *std::max_element(spacing.begin(), spacing.end())),
              1e-6);
}

TEST(Adaptive, SameBytesAtAnyNumberOfThreads) {
  // Four workers even where there are fewer cores.
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  const Phantom phantom = tree_cases(3).back().make();
  const Result first = convert_adaptively(phantom.view(), Parameters(), 1);
  ASSERT_GT(first.mesh.triangle_count(), 1000u);
  for (const int threads : {2, 4, 4}) {
    const Result again = convert_adaptively(phantom.view(), Parameters(), threads);
    ASSERT_EQ(again.mesh.vertices, first.mesh.vertices) << threads;
    ASSERT_EQ(again.mesh.triangles, first.mesh.triangles) << threads;
  }
}

/// Balls of the given radius about the points (x, 11.5, 11.5), x from 12 to 52.
DenseVolume bar(const std::function<double(double)>& radius_at) {
  DenseVolume volume({64, 24, 24});
  const auto covered = [&](int x, int y, int z) {
    for (double centre = 12; centre <= 52; centre += 0.5)
      if (std::hypot(x - centre, y - 11.5, z - 11.5) < radius_at(centre)) return true;
    return false;
  };
  for (int z = 0; z < 24; ++z)
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 64; ++x) volume.at(x, y, z) = covered(x, y, z);
  return volume;
}

/// The circumference over the mean edge length, from x = low to high.
double edges_round(const TriangleMesh& mesh, float low, float high, double radius) {
  double sum = 0;
  int count = 0;
  const auto at = [&](std::size_t corner) {
    const float* p = &mesh.vertices[3 * std::size_t{mesh.triangles[corner]}];
    return Vec3{p[0], p[1], p[2]};
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 a = at(t + i), b = at(t + (i + 1) % 3);
      if (a.x < low || a.x > high) continue;
      sum += double{norm(b - a)};
      ++count;
    }
  EXPECT_GT(count, 30);
  return 2 * std::numbers::pi * radius * count / sum;
}

TEST(Adaptive, EdgesRoundAVesselAreAsManyAsAskedFor) {
  const DenseVolume plain = bar([](double) { return 5; });
  const DenseVolume tapered = bar([](double x) { return 10.5 - x / 6.5; });
  for (const double want : {9.0, 12.0, 16.0}) {
    SCOPED_TRACE(want);
    EdgeLengths edges;
    edges.edges_around = want;
    edges.edge_min = 0.5;
    edges.edge_max = 10;
    const Result even = convert_adaptively(plain.view(), edges);
    expect_proven(even, plain.view());
    EXPECT_NEAR(edges_round(even.mesh, 20, 44, 5), want, 0.25 * want);
    const Result narrowing = convert_adaptively(tapered.view(), edges);
    expect_proven(narrowing, tapered.view());
    for (const float x : {18.0f, 26.0f, 34.0f, 42.0f}) {
      SCOPED_TRACE(x);
      EXPECT_NEAR(edges_round(narrowing.mesh, x - 4, x + 4, 10.5 - x / 6.5), want, 0.25 * want);
    }
  }
}

TEST(Adaptive, AsManyTrianglesAsAskedFor) {
  const Phantom phantom = make_phantom("y_branch");
  const auto usual = static_cast<double>(convert_adaptively(phantom.view()).mesh.triangle_count());
  for (const double share : {0.6, 1.5}) {
    EdgeLengths edges;
    edges.triangles = static_cast<std::int64_t>(share * usual);
    const Result result = convert_adaptively(phantom.view(), edges);
    expect_proven(result, phantom.view());
    EXPECT_NEAR(static_cast<double>(result.mesh.triangle_count()), share * usual,
                0.1 * share * usual);
  }
}

TEST(Adaptive, NoiseIsProvenAtAllDensities) {
  unsigned seed = 0;
  for (const double density : {0.05, 0.5, 0.9}) {
    SCOPED_TRACE(density);
    const DenseVolume volume = random_volume({8, 7, 9}, density, ++seed);
    expect_proven(convert_adaptively(volume.view()), volume.view());
  }
}

/// Random specks on a grid of six voxels, and in the ball beside them cavities of one voxel.
DenseVolume dust() {
  DenseVolume volume({64, 30, 30});
  std::mt19937 random(7);
  for (int z = 3; z < 27; z += 6)
    for (int y = 3; y < 27; y += 6)
      for (int x = 3; x < 34; x += 6)
        for (int n = 0; n < 3; ++n)
          volume.at(x + static_cast<int>(random() % 2), y + static_cast<int>(random() % 2),
                    z + static_cast<int>(random() % 2)) = 1;
  for (int z = 0; z < 30; ++z)
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 30; ++x) {
        const double from = std::hypot(x - 14.5, y - 14.5, z - 14.5);
        volume.at(34 + x, y, z) = from < 12.5 && !(from < 11 && x % 6 == 0 && y % 6 == 0 &&
                                                   z % 6 == static_cast<int>(random() % 6));
      }
  return volume;
}

TEST(Adaptive, SpecksAndCavitiesOfOneVoxelAreWellShaped) {
  const DenseVolume volume = dust();
  const Result result = convert_adaptively(volume.view());
  expect_proven(result, volume.view());
  EXPECT_GE(result.report.check.topology.pieces, 90);
  EXPECT_GE(result.report.check.topology.cavities, 8);
  EXPECT_EQ(result.report.mesh.base_share, 0);
  EXPECT_EQ(result.report.quality.edge_ratio_below_03, 0);
  EXPECT_GE(result.report.quality.edge_ratio_above_08, 0.6);
}

TEST(Adaptive, PresetsAreProvenAndOfTheirSizes) {
  const Phantom phantom = make_phantom("y_branch");
  const auto count_of = [&](const char* preset) {
    SCOPED_TRACE(preset);
    Parameters parameters;
    set_preset(preset, parameters);
    const Result result = convert_adaptively(phantom.view(), parameters);
    expect_proven(result, phantom.view());
    return result.mesh.triangle_count();
  };
  const std::size_t paper = count_of("paper"), usual = count_of("default"),
                    simulator = count_of("simulator");
  EXPECT_LT(usual, 0.6 * static_cast<double>(paper));
  EXPECT_LT(simulator, 0.8 * static_cast<double>(usual));
}

TEST(Adaptive, CancelledInEachOfItsStages) {
  const Phantom phantom = tree_cases(2).back().make();
  Parameters parameters;
  parameters.surface = SurfaceKind::adaptive;
  for (const char* stage : {"sizes", "remesh", "expand", "stitch", "finish", "settle", "check"}) {
    SCOPED_TRACE(stage);
    Context stopping = make_threads(2);
    stopping.progress = [&](std::string_view phase, double) { return phase != stage; };
    try {
      convert(phantom.view(), parameters, stopping);
      ADD_FAILURE() << "not cancelled";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled);
      EXPECT_NE(std::string(error.what()).find(stage), std::string::npos) << error.what();
    }
    EXPECT_EQ(stopping.backends.back()->bytes_held(), 0u);
  }
}

/// Two voxels that touch at a corner or an edge, which does not join them, keep about the size that
/// marching cubes gives them: a sixth of a voxel each.
TEST(Adaptive, PiecesThatTouchKeepTheirSize) {
  for (const std::array<int, 3>& second : {std::array{4, 4, 4}, std::array{4, 4, 3}})
    for (const Connectivity connectivity : {Connectivity::face, Connectivity::edge}) {
      const bool over_edge = second[2] == 3;
      if (over_edge && connectivity == Connectivity::edge) continue;  // joined
      for (const SurfaceKind surface : {SurfaceKind::adaptive, SurfaceKind::base}) {
        DenseVolume volume({8, 8, 8});
        volume.box({3, 3, 3}, {3, 3, 3}).box(second, second);
        Context context = make_threads(2);
        Parameters parameters;
        parameters.connectivity = connectivity;
        parameters.surface = surface;
        const Report report = convert(volume.view(), parameters, context).report;
        EXPECT_EQ(report.check.topology.pieces, 2);
        EXPECT_GT(report.quality.volume, 0.15);
        EXPECT_LT(report.quality.volume, 0.7);
      }
    }
}

/// Of the shells whose triangles begin where a test holds.
template <class Test>
double volume_where(const TriangleMesh& mesh, const Test& test) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const std::uint32_t* v = &mesh.triangles[3 * t];
    const Vec3 a = vertex_at(mesh, v[0]), b = vertex_at(mesh, v[1]), c = vertex_at(mesh, v[2]);
    if (test(a)) sum += dot(a, cross(b, c)) / 6;
  }
  return sum;
}

/// Marching cubes gives a line half its voxels' volume, a speck and a cavity a sixth.
TEST(Adaptive, PartsOfAVoxelKeepTheirSizeBesideThickOnes) {
  for (const int gap : {1, 2, 3, 4}) {
    SCOPED_TRACE(gap);
    DenseVolume volume({24, 16, 32});
    const int line = 11 + gap, speck = line + 1 + gap;
    volume.box({4, 3, 3}, {19, 12, 10}).box({6, 7, line}, {17, 7, line});
    volume.at(11, 7, speck) = 1;
    volume.at(11, 7, 6) = 0;
    const Result result = convert_adaptively(volume.view());
    expect_proven(result, volume.view());
    const auto volume_at = [&](int height) {
      return volume_where(result.mesh, [height](const Vec3& p) {
        return std::abs(p.z - static_cast<float>(height)) < 0.9f;
      });
    };
    EXPECT_GT(volume_at(line), 0.3 * 12);
    EXPECT_LT(volume_at(line), 1.2 * 12);
    EXPECT_GT(volume_at(speck), 0.1);
    EXPECT_LT(volume_at(speck), 1);
    const double cavity = volume_where(result.mesh, [](const Vec3& p) {
      return squared_norm(p - Vec3{11, 7, 6}) < 1;
    });
    EXPECT_LT(cavity, -0.05);
    EXPECT_GT(cavity, -1);
  }
}

TEST(Adaptive, ImpossibleNumbersOfTrianglesAreRefusedWithAPossibleOne) {
  const Phantom phantom = make_phantom("y_branch");
  for (const auto& [triangles, side] :
       {std::pair{std::int64_t{2}, "or more"}, std::pair{std::int64_t{1000000000}, "or fewer"}}) {
    EdgeLengths edges;
    edges.triangles = triangles;
    try {
      convert_adaptively(phantom.view(), edges);
      ADD_FAILURE() << "accepted " << triangles;
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_EQ(error.code(), ErrorCode::usage) << message;
      EXPECT_NE(message.find(std::to_string(triangles) + " triangles"), std::string::npos);
      EXPECT_NE(message.find("ask for about "), std::string::npos) << message;
      EXPECT_NE(message.find(side), std::string::npos) << message;
    }
  }
}

/// A prediction may be far off where edges are as long as the vessel is wide: what comes out
/// counts.
void expect_met_or_refused_with_what_is(const VolumeView& volume, std::int64_t triangles) {
  const auto met = [&](std::int64_t count) {
    EdgeLengths edges;
    edges.triangles = count;
    const Result result = convert_adaptively(volume, edges);
    return std::fabs(static_cast<double>(result.report.check.triangles) / count - 1) <= 0.1;
  };
  try {
    EXPECT_TRUE(met(triangles)) << triangles;
  } catch (const Error& error) {
    const std::string message = error.what(), before = "ask for about ";
    EXPECT_NE(message.find(std::to_string(triangles) + " triangles"), std::string::npos);
    EXPECT_EQ(message.find("prediction"), std::string::npos) << message;
    const std::size_t at = message.find(before);
    ASSERT_NE(at, std::string::npos) << message;
    const std::int64_t possible = std::stoll(message.substr(at + before.size()));
    EXPECT_GT(possible, triangles) << message;
    EXPECT_TRUE(met(possible)) << message;
  }
}

TEST(Adaptive, FewTrianglesAreMetOrRefusedWithANumberThatIsMet) {
  const Phantom torus = make_phantom("torus");
  for (const std::int64_t triangles : {200, 250, 300, 400})
    expect_met_or_refused_with_what_is(torus.view(), triangles);
}

/// What the refusal of one number names is refused itself, and so on.
TEST(Adaptive, ANumberThatIsNamedIsMetWhereThePredictionIsFarOff) {
  DenseVolume volume({30, 27, 24});  // a tube with a bulb
  for (int z = 4; z < 18; ++z)
    for (int y = 0; y < 27; ++y)
      for (int x = 0; x < 30; ++x)
        volume.at(x, y, z) = (x - 13) * (x - 13) + (y - 12) * (y - 12) < 17 ||
                             (x - 13) * (x - 13) + (y - 15) * (y - 15) + (z - 8) * (z - 8) < 38;
  VolumeView view = volume.view();
  view.geometry.spacing = {0.7, 0.9, 1.3};
  for (const std::int64_t triangles : {50, 150})
    expect_met_or_refused_with_what_is(view, triangles);
}

}  // namespace
}  // namespace vasamesh::test
