/// \file
/// A device that drops sub-normal numbers and takes liberties with sums: it is taken where it was
/// asked for, its surface is proven by the CPU and near oneTBB's, and everything says so.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "backend/backend.h"
#include "measure/bench.h"
#include "opencl/backend.h"
#include "opencl/tuning.h"
#include "phantom/phantom.h"
#include "stages/distance.h"
#include "support/environment.h"
#include "support/failing_opencl.h"
#include "support/scratch.h"
#include "tbb/backend.h"
#include "tune.h"
#include "vasamesh/errors.h"
#include "vasamesh/host.h"
#include "vasamesh/pipeline.h"

namespace vasamesh {
namespace {

constexpr char kSaid[] = "drops sub-normal numbers";

class OtherArithmetic : public ::testing::Test {
 protected:
  void SetUp() override {
    if (list_opencl_devices().empty()) GTEST_SKIP() << "no OpenCL device here";
    failing_opencl::pretend_options("-cl-denorms-are-zero -cl-unsafe-math-optimizations");
  }
  void TearDown() override { failing_opencl::reset(); }

  static Context context_on(const std::string& backend) {
    ContextOptions options;
    options.backend = backend;
    options.threads = 2;
    return make_context(options);
  }
};

TEST_F(OtherArithmetic, SurfaceIsProvenAndNear) {
  const Phantom phantom = make_phantom("torus");
  Context device = context_on("opencl"), host = context_on("tbb");
  const Result got = convert(phantom.view(), {}, device), want = convert(phantom.view(), {}, host);
  ASSERT_NE(got.mesh.vertices, want.mesh.vertices) << "no liberty was taken";
  EXPECT_TRUE(got.report.check.passed);
  EXPECT_EQ(got.report.check.topology, want.report.check.topology);
  const DistanceReport distance =
      measure_distance(*host.backends.back(), got.mesh, want.mesh, phantom.geometry.spacing[0]);
  for (const OneWayDistance& way : {distance.to, distance.back}) {
    EXPECT_LE(way.maximum, 0.25 * distance.voxel);
    EXPECT_LE(way.mean, 0.05 * distance.voxel);
  }
  for (const StageReport& stage : got.report.stages) {
    EXPECT_EQ(stage.other_arithmetic, stage.backend == "opencl" ? kSaid : "") << stage.name;
    if (stage.name != "check") continue;
    EXPECT_EQ(stage.backend, "tbb");
    EXPECT_NE(stage.host_reason.find("proofs"), std::string::npos) << stage.host_reason;
  }
  const Result again = convert(phantom.view(), {}, device);
  EXPECT_EQ(again.mesh.vertices, got.mesh.vertices);
  EXPECT_EQ(again.mesh.triangles, got.mesh.triangles);
}

TEST_F(OtherArithmetic, RefusedWhereBytesMustBeTheSame) {
  try {
    make_opencl_backend({});
    FAIL() << "opened";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::no_device);
    EXPECT_NE(std::string(error.what()).find(kSaid), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("--backend tbb"), std::string::npos) << error.what();
  }
}

/// By name, but not by `auto`.
TEST_F(OtherArithmetic, TunedForThoseWhoNameIt) {
  const Scratch folder;
  const Variable cache("XDG_CACHE_HOME", folder / "cache");
  failing_opencl::pretend(CL_DEVICE_MAX_WORK_GROUP_SIZE, 32);  // for one shape alone
  const DeviceInfo device = list_devices()[1];
  const TuneResult result = tune_device(device, 2, {});
  EXPECT_TRUE(result.best.agrees);
  EXPECT_EQ(result.other_arithmetic, kSaid);
  EXPECT_TRUE(load_shape(device.opencl_index, {}));
  const DeviceWorth worth = worth_of(device, make_tbb_backend(2, nullptr), nullptr);
  EXPECT_EQ(worth.stages, 0u);
  EXPECT_NE(worth.reason.find(kSaid), std::string::npos) << worth.reason;
}

TEST_F(OtherArithmetic, LeftAloneInATrial) {
  const Scratch folder;
  const Variable cache("XDG_CACHE_HOME", folder / "cache");
  const std::shared_ptr<Backend> host = make_tbb_backend(2, nullptr);
  const DeviceWorth worth = worth_of(list_devices()[1], host, nullptr);
  EXPECT_EQ(worth.stages, 0u);
  EXPECT_NE(worth.reason.find(kSaid), std::string::npos) << worth.reason;
}

TEST_F(OtherArithmetic, BenchTellsHowFarTheSurfaceIs) {
  const Phantom phantom = make_phantom("torus");
  const BenchTable table = bench(phantom.view(), {}, bench_ways({}, "", {2}), 1);
  ASSERT_EQ(table.runs.size(), 2u);
  EXPECT_EQ(table.runs[0].other_arithmetic, "");
  EXPECT_EQ(table.runs[1].other_arithmetic, kSaid);
  EXPECT_GT(table.runs[1].largest_distance, 0);
  EXPECT_LE(table.runs[1].largest_distance, 0.25);
  EXPECT_LE(table.runs[1].mean_distance, 0.05);
  EXPECT_FALSE(std::all_of(table.runs[1].stages.begin(), table.runs[1].stages.end(),
                           [](const BenchStage& stage) { return stage.agrees; }));
}

}  // namespace
}  // namespace vasamesh
