/// \file
/// The contract of convert(): parameters and their ranges, spaces and mirrored volumes, the same
/// bytes at any thread count, cancelling at every stage, the limit of memory, the report.

#include "vasamesh/pipeline.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "backend/backend.h"
#include "stages/volume_check.h"
#include "support/cases.h"
#include "support/dense_volume.h"
#include "support/invariants.h"
#include "vasamesh/host.h"

namespace vasamesh::test {
namespace {

Context make_threads(int threads) {
  return make_context({.backend = "tbb", .device = "", .threads = threads});
}

Context& context() {
  static Context shared = make_threads(2);
  return shared;
}

const Phantom& small_tree() {
  static const Phantom phantom = tree_cases(7).back().make();
  return phantom;
}

Phantom y_branch() { return make_phantom("y_branch"); }

/// The error of a call; fails where there is none.
Error error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no error";
  return Error(ErrorCode::internal, "");
}

Error error_of(const Parameters& parameters) {
  return error_of([&] { convert(y_branch().view(), parameters, context()); });
}

void expect_refused(const Parameters& parameters, const std::string& field) {
  SCOPED_TRACE(field);
  const Error error = error_of(parameters);
  EXPECT_EQ(error.code(), ErrorCode::usage) << error.what();
  EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
  EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
}

template <class T>
Parameters with(T Parameters::*field, T value) {
  Parameters parameters;
  parameters.*field = value;
  return parameters;
}

TEST(PipelineParameters, OutOfRangeIsNamed) {
  for (const int neighbours : {2, 65, -1})
    expect_refused(with(&Parameters::neighbours, neighbours), "--neighbours");
  for (const int depth : {-1, 25}) expect_refused(with(&Parameters::depth, depth), "--depth");
  for (const double width : {0.49, 4.01, -1.0, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()})
    expect_refused(with(&Parameters::kernel_width, width), "--kernel-width");
  expect_refused(with(&Parameters::min_component, std::int64_t{-1}), "--min-component");
  expect_refused(with(&Parameters::max_memory, std::int64_t{-1}), "--max-memory");
  expect_refused(with(&Parameters::connectivity, static_cast<Connectivity>(8)), "--connectivity");
}

TEST(PipelineParameters, LimitsOfRangesAreAccepted) {
  const Phantom phantom = y_branch();
  for (const Parameters& parameters :
       {with(&Parameters::neighbours, 3), with(&Parameters::neighbours, 64),
        with(&Parameters::kernel_width, 0.5), with(&Parameters::kernel_width, 4.0),
        with(&Parameters::normals, NormalMode::gradient)})
    expect_good_surface(convert(phantom.view(), parameters, context()).mesh, phantom.view());
}

TEST(PipelineParameters, DepthFromTwoBelowToOneAboveTheRegular) {
  const DenseVolume volume = DenseVolume({20, 20, 20}).box({3, 3, 3}, {16, 16, 16});
  const Report report = convert(volume.view(), {}, context()).report;
  ASSERT_EQ(report.thin_points, 0);  // so that there is no refined level
  const int regular = report.levels.back().depth;
  for (const LevelReport& level : report.levels)
    EXPECT_EQ(level.cells[0], std::int64_t{24} << (level.depth - report.levels.front().depth));
  for (int depth = regular - 2; depth <= regular + 1; ++depth) {
    SCOPED_TRACE(depth);
    const Result result = convert(volume.view(), with(&Parameters::depth, depth), context());
    expect_good_surface(result.mesh, volume.view());
    int solved = 0;
    for (const LevelReport& level : result.report.levels)
      if (level.iterations > 0) solved = std::max(solved, level.depth);
    EXPECT_EQ(solved, depth);
  }
  for (const int depth : {regular - 3, regular + 2}) {
    const Error error =
        error_of([&] { convert(volume.view(), with(&Parameters::depth, depth), context()); });
    EXPECT_EQ(error.code(), ErrorCode::usage);
    EXPECT_NE(std::string(error.what())
                  .find(std::to_string(regular - 2) + " to " + std::to_string(regular + 1)),
              std::string::npos)
        << error.what();
  }
}

TEST(PipelineParameters, SmallPiecesAreDroppedAndReported) {
  DenseVolume volume({20, 12, 12});
  volume.box({2, 2, 2}, {7, 7, 7}).box({12, 2, 2}, {13, 3, 3}).box({16, 8, 8}, {16, 8, 8});
  const Result all = convert(volume.view(), {}, context());
  const Result large =
      convert(volume.view(), with(&Parameters::min_component, std::int64_t{9}), context());
  EXPECT_EQ(all.report.check.topology.pieces, 3);
  EXPECT_EQ(large.report.check.topology.pieces, 1);
  EXPECT_EQ(large.report.input.dropped.count, 2);
  const Error error = error_of([&] {
    convert(volume.view(), with(&Parameters::min_component, std::int64_t{1000}), context());
  });
  EXPECT_EQ(error.code(), ErrorCode::bad_input);
  EXPECT_NE(std::string(error.what()).find("--min-component, 1000"), std::string::npos)
      << error.what();
}

TEST(PipelineParameters, ClosedHandlesAreTakenOffTheTopologyWanted) {
  std::int64_t closed = 0;
  for (const unsigned seed : {1u, 2u}) {
    const DenseVolume volume = random_volume({9, 10, 11}, 0.25, seed);
    const Topology kept = convert(volume.view(), {}, context()).report.check.wanted;
    const Report report =
        convert(volume.view(), with(&Parameters::close_handles, true), context()).report;
    EXPECT_TRUE(report.check.passed);
    EXPECT_EQ(report.check.topology, report.check.wanted);
    EXPECT_EQ(report.check.wanted.pieces, kept.pieces);
    EXPECT_EQ(report.check.wanted.handles + report.relabel.handles_closed, kept.handles);
    EXPECT_EQ(report.check.wanted.cavities + report.relabel.cavities_closed, kept.cavities);
    closed += report.relabel.handles_closed;
  }
  EXPECT_GT(closed, 0);
}

TEST(PipelineInput, NothingInTheForeground) {
  const DenseVolume volume({9, 8, 7});
  EXPECT_EQ(error_of([&] { convert(volume.view(), {}, context()); }).code(), ErrorCode::bad_input);
}

TEST(PipelineInput, ContextWithoutBackends) {
  Context nothing;
  const DenseVolume volume = DenseVolume({3, 3, 3}).box({1, 1, 1}, {1, 1, 1});
  EXPECT_EQ(error_of([&] { convert(volume.view(), {}, nothing); }).code(), ErrorCode::usage);
}

TEST(PipelineInput, BitsGiveTheSurfaceOfBytes) {
  const DenseVolume volume = random_volume({19, 11, 9}, 0.3, 3);
  std::vector<std::uint8_t> bits(std::size_t{3} * 11 * 9);
  for (int z = 0; z < 9; ++z)
    for (int y = 0; y < 11; ++y)
      for (int x = 0; x < 19; ++x)
        if (volume.object(x, y, z))
          bits[static_cast<std::size_t>(x / 8 + 3 * (y + 11 * z))] |=
              static_cast<std::uint8_t>(1u << x % 8);
  VolumeView packed = volume.view();
  packed.data = bits.data();
  packed.format = VoxelFormat::bits;
  const Result from_bytes = convert(volume.view(), {}, context());
  const Result from_bits = convert(packed, {}, context());
  EXPECT_EQ(from_bits.mesh.vertices, from_bytes.mesh.vertices);
  EXPECT_EQ(from_bits.mesh.triangles, from_bytes.mesh.triangles);
}

TEST(PipelineBytes, SameAtAnyThreadCountAndInTenRepeats) {
  // Four workers even where there are fewer cores.
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  const Result first = convert(small_tree().view(), {}, context());
  ASSERT_GT(first.mesh.triangle_count(), 1000u);
  for (const int threads : {1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4}) {
    Context other = make_threads(threads);
    const Result again = convert(small_tree().view(), {}, other);
    ASSERT_EQ(again.mesh.vertices, first.mesh.vertices) << threads;
    ASSERT_EQ(again.mesh.triangles, first.mesh.triangles) << threads;
  }
}

TEST(PipelineBytes, ConverterGivesTheSameEachTime) {
  Converter converter(make_threads(2));
  const Phantom other = y_branch();
  const Result want = convert(small_tree().view(), {}, context());
  for (int i = 0; i < 2; ++i) {
    const Result got = converter.convert(small_tree().view(), {});
    EXPECT_EQ(got.mesh.vertices, want.mesh.vertices);
    EXPECT_EQ(got.mesh.triangles, want.mesh.triangles);
    EXPECT_GT(converter.convert(other.view(), {}).mesh.triangle_count(), 0u);
  }
}

/// Rotation about an axis that is none of the volume's.
std::array<double, 9> oblique(bool mirrored) {
  const double a = 2.0 / 3, b = 1.0 / 3, s = mirrored ? -1 : 1;
  return {a, -b, s * a, a, a, s * -b, -b, a, s * a};
}

TEST(PipelineSpace, MirroredAndObliqueDirectionsGiveOutwardSurfaces) {
  const Phantom phantom = y_branch();
  for (const std::array<double, 9>& direction : {std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1},
                                                 {-1, 0, 0, 0, 1, 0, 0, 0, 1},
                                                 {-1, 0, 0, 0, -1, 0, 0, 0, 1},
                                                 {0, 1, 0, 1, 0, 0, 0, 0, 1},
                                                 oblique(false),
                                                 oblique(true)})
    for (const Space space : {Space::lps, Space::ras, Space::voxel}) {
      SCOPED_TRACE(::testing::Message() << "direction " << direction[0] << " " << direction[1]
                                        << ", space " << static_cast<int>(space));
      VolumeView volume = phantom.view();
      volume.geometry.direction = direction;
      volume.geometry.origin = {12.5, -31, 170};
      const Result result = convert(volume, with(&Parameters::space, space), context());
      expect_good_surface(result.mesh, volume, Connectivity::vertex, space);
      EXPECT_GT(result.report.quality.volume, 0);
    }
}

TEST(PipelineSpace, RasIsAChangeOfSign) {
  const Phantom phantom = y_branch();
  const Result lps = convert(phantom.view(), {}, context());
  const Result ras = convert(phantom.view(), with(&Parameters::space, Space::ras), context());
  ASSERT_EQ(ras.mesh.vertices.size(), lps.mesh.vertices.size());
  EXPECT_EQ(ras.mesh.triangles, lps.mesh.triangles);
  for (std::size_t i = 0; i < lps.mesh.vertices.size(); ++i)
    ASSERT_EQ(ras.mesh.vertices[i], (i % 3 < 2 ? -1 : 1) * lps.mesh.vertices[i]) << i;
}

TEST(PipelineSpace, AnOriginTooFarForFloat32IsRefused) {
  const Phantom phantom = y_branch();
  VolumeView volume = phantom.view();
  volume.geometry.spacing = {1, 1, 1};
  volume.geometry.origin = {130000, 130000, 0};  // steps of 1/128 mm, from 131072 on of 1/64
  for (const SurfaceKind surface : {SurfaceKind::adaptive, SurfaceKind::base})
    EXPECT_NO_THROW(convert(volume, with(&Parameters::surface, surface), context()));
  EXPECT_NE(far_out(volume.geometry, Space::lps).find("--space voxel"), std::string::npos);
  EXPECT_EQ(far_out(volume.geometry, Space::voxel), "");
  EXPECT_EQ(far_out(phantom.geometry, Space::lps), "");
  for (const std::array<double, 3>& origin :
       {std::array<double, 3>{0, 131072, 0}, {-1e7, 0, 0}, {0, 0, 1e39}}) {
    volume.geometry.origin = origin;
    for (const Space space : {Space::lps, Space::ras}) {
      const Error error =
          error_of([&] { convert(volume, with(&Parameters::space, space), context()); });
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(std::string(error.what()).find("--space voxel"), std::string::npos);
    }
    EXPECT_NO_THROW(convert(volume, with(&Parameters::space, Space::voxel), context()));
  }
}

TEST(PipelineInput, AVolumeThatIsNoneIsRefused) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Phantom phantom = y_branch();
  std::vector<std::pair<std::string, VolumeView>> bad;
  const auto add = [&](const char* reason) -> VolumeView& {
    return bad.emplace_back(reason, phantom.view()).second;
  };
  add("no voxels").data = nullptr;
  add("format").format = static_cast<VoxelFormat>(7);
  for (const std::int64_t size : {std::int64_t{0}, std::int64_t{-5}, std::int64_t{1} << 32,
                                  std::numeric_limits<std::int64_t>::max()})
    add("voxels along an axis").geometry.size[1] = size;
  for (const double spacing : {0.0, -1.0, 1e-300, 1e300, kNaN, kInfinity})
    for (const std::size_t axis : {0, 2}) add("spacing").geometry.spacing[axis] = spacing;
  add("100-fold").geometry.spacing = {1, 0.5, 51};
  for (const double origin : {kNaN, kInfinity, -kInfinity})
    add("origin").geometry.origin[1] = origin;
  add("direction").geometry.direction.fill(0);
  add("direction").geometry.direction[4] = kNaN;
  add("direction").geometry.direction[1] = 0.5;
  add("direction").geometry.direction = {2, 0, 0, 0, 2, 0, 0, 0, 2};
  for (const auto& [reason, volume] : bad)
    for (const Space space : {Space::lps, Space::voxel}) {
      SCOPED_TRACE(reason);
      const Error error = error_of(
          [&, &volume = volume] { convert(volume, with(&Parameters::space, space), context()); });
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
    }
}

/// What progress told: (phase, fraction) in order, without what it told again.
using Told = std::vector<std::pair<std::string, double>>;

Told progress_of(const Phantom& phantom) {
  Told told;
  Context watching = make_threads(2);
  watching.progress = [&](std::string_view phase, double fraction) {
    const Told::value_type word{phase, fraction};
    if (told.empty() || told.back() != word) told.push_back(word);
    return true;
  };
  convert(phantom.view(), {}, watching);
  return told;
}

TEST(PipelineProgress, EachStageFromNoneToAll) {
  const Phantom phantom = y_branch();
  const Told told = progress_of(phantom);
  std::vector<std::string> begun;
  std::string phase;
  double last = 1;
  for (const auto& [name, fraction] : told) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    if (name != phase) {
      EXPECT_EQ(last, 1) << phase;
      EXPECT_EQ(fraction, 0) << name;
      begun.push_back(phase = name);
    } else {
      EXPECT_GE(fraction, last) << name;
    }
    last = fraction;
  }
  EXPECT_EQ(last, 1);
  const Report report = convert(phantom.view(), {}, context()).report;
  ASSERT_EQ(report.stages.size(), begun.size());
  for (std::size_t i = 0; i < begun.size(); ++i) {
    EXPECT_EQ(report.stages[i].name, begun[i]);
    EXPECT_EQ(report.stages[i].backend, "tbb");
    EXPECT_FALSE(report.stages[i].device.empty());
    EXPECT_GE(report.stages[i].seconds, 0);
  }
}

TEST(PipelineProgress, FalseCancelsWhereverItIsSaid) {
  const Phantom phantom = y_branch();
  const Told told = progress_of(phantom);
  ASSERT_GE(told.size(), 16u);
  for (std::size_t stop = 0; stop < told.size(); ++stop) {
    SCOPED_TRACE(told[stop].first);
    Context stopping = make_threads(2);
    bool said = false;
    stopping.progress = [&](std::string_view phase, double fraction) {
      EXPECT_FALSE(said) << "asked again";
      said = told[stop] == Told::value_type{phase, fraction};
      return !said;
    };
    const Error error = error_of([&] { convert(phantom.view(), {}, stopping); });
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
    EXPECT_NE(std::string(error.what()).find(told[stop].first), std::string::npos);
    EXPECT_EQ(stopping.backends.back()->bytes_held(), 0u);
  }
}

TEST(PipelineProgress, FlagCancelsAtEveryStage) {
  const Phantom phantom = y_branch();
  std::set<std::string> phases;
  for (const auto& [name, fraction] : progress_of(phantom)) phases.insert(name);
  for (const std::string& phase : phases) {
    SCOPED_TRACE(phase);
    std::atomic<bool> cancel{false};
    std::string last;
    Context stopping = make_threads(2);
    stopping.cancel = &cancel;
    stopping.progress = [&](std::string_view name, double) {
      last = name;
      if (name == phase) cancel = true;
      return true;
    };
    EXPECT_EQ(error_of([&] { convert(phantom.view(), {}, stopping); }).code(),
              ErrorCode::cancelled);
    EXPECT_EQ(last, phase);
    cancel = false;
    stopping.progress = nullptr;
    EXPECT_GT(convert(phantom.view(), {}, stopping).mesh.triangle_count(), 0u);
  }
}

TEST(PipelineProgress, FlagSetBeforehand) {
  const std::atomic<bool> cancel{true};
  Context stopping = make_threads(2);
  stopping.cancel = &cancel;
  EXPECT_EQ(error_of([&] { convert(y_branch().view(), {}, stopping); }).code(),
            ErrorCode::cancelled);
}

TEST(PipelineMemory, RefusedBelowThePeakAndDoneAtIt) {
  const Phantom phantom = y_branch();
  Context limited = make_threads(2);
  Backend& backend = *limited.backends.back();
  const Result want = convert(phantom.view(), {}, limited);
  const auto peak = static_cast<std::int64_t>(backend.bytes_peak());
  ASSERT_GT(peak, 0);
  for (const std::int64_t bytes : {std::int64_t{1}, peak / 100, peak / 10, peak / 2, peak - 1}) {
    SCOPED_TRACE(bytes);
    const Error error =
        error_of([&] { convert(phantom.view(), with(&Parameters::max_memory, bytes), limited); });
    EXPECT_EQ(error.code(), ErrorCode::refused) << error.what();
    EXPECT_EQ(backend.bytes_held(), 0u);
  }
  const Result got = convert(phantom.view(), with(&Parameters::max_memory, peak), limited);
  EXPECT_EQ(got.mesh.vertices, want.mesh.vertices);
  EXPECT_GT(convert(phantom.view(), {}, limited).mesh.triangle_count(), 0u);
}

/// Voxels that lie alone, `step` apart from `first` on, along each axis.
DenseVolume lone_voxels(int side, int step, int first) {
  DenseVolume volume({side, side, side});
  for (int z = first; z < side; z += step)
    for (int y = first; y < side; y += step)
      for (int x = first; x < side; x += step) volume.at(x, y, z) = 1;
  return volume;
}

TEST(PipelineMemory, PlanIsAboveThePeakAndNotFarAbove) {
  const auto expect_planned = [](const VolumeView& volume, double most) {
    Context fresh = make_threads(2);
    Parameters parameters;
    parameters.surface = SurfaceKind::base;
    const auto planned =
        static_cast<double>(convert(volume, parameters, fresh).report.bytes_planned);
    const auto peak = static_cast<double>(fresh.backends.back()->bytes_peak());
    EXPECT_GE(planned, peak);
    EXPECT_LE(planned, most * peak);
  };
  expect_planned(y_branch().view(), 8);
  expect_planned(small_tree().view(), 8);
  expect_planned(make_phantom("full_box").view(), 8);
  expect_planned(make_phantom("single_voxel").view(), 4);
  for (const auto& [step, first] : {std::array{7, 3}, std::array{11, 4}, std::array{16, 3},
                                    std::array{24, 11}, std::array{40, 4}, std::array{40, 8}}) {
    SCOPED_TRACE(step);
    expect_planned(lone_voxels(64, step, first).view(), 4);
  }
}

TEST(PipelineReport, SaysWhatWasDone) {
  const Report report = convert(small_tree().view(), {}, context()).report;
  EXPECT_EQ(report.geometry.size, small_tree().geometry.size);
  EXPECT_GT(report.points, report.thin_points);
  EXPECT_GT(report.thin_points, 0);
  const auto with_leaves = std::count_if(report.levels.begin(), report.levels.end(),
                                         [](const LevelReport& level) { return level.leaves > 0; });
  EXPECT_GE(with_leaves, 2) << "one leaf depth alone";
  for (const LevelReport& level : report.levels) {
    EXPECT_GE(level.nodes, level.leaves);
    EXPECT_GE(level.leaves, 0);
    EXPECT_GT(level.iterations, 0);
    EXPECT_LT(level.residual, level.initial_residual);
  }
  EXPECT_GT(report.relabel.lattice_nodes, 0);
  EXPECT_GT(report.relabel.flips, 0);
  EXPECT_GT(report.quality.area, 0);
}

}  // namespace
}  // namespace vasamesh::test
