/// A conversion with the OpenCL backend gives the surface of one without, byte by byte.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <vector>

#include "backend/backend.h"
#include "opencl/backend.h"
#include "phantom/phantom.h"
#include "tbb/backend.h"
#include "vasamesh/host.h"
#include "vasamesh/pipeline.h"

namespace vasamesh {
namespace {

Result convert_on(const std::string& backend, const Phantom& phantom,
                  const Parameters& parameters = {}) {
  ContextOptions options;
  options.backend = backend;
  options.threads = 2;
  Context context = make_context(options);
  return convert(phantom.view(), parameters, context);
}

class OpenClConvert : public ::testing::TestWithParam<const char*> {};

TEST_P(OpenClConvert, SameSurfaceAsOneTbb) {
  if (list_opencl_devices().empty()) GTEST_SKIP() << "no OpenCL device here";
  const Phantom phantom = make_phantom(GetParam());
  const Result got = convert_on("opencl", phantom), want = convert_on("tbb", phantom);
  ASSERT_GT(want.mesh.triangle_count(), 0u);
  EXPECT_EQ(got.mesh.vertices, want.mesh.vertices);
  EXPECT_EQ(got.mesh.triangles, want.mesh.triangles);
  for (const StageReport& stage : got.report.stages) {
    const bool may_be_idle = std::set<std::string>{"remesh", "stitch"}.contains(stage.name);
    const bool host = std::set<std::string>{"settle", "quality"}.contains(stage.name) ||
                      (may_be_idle && stage.launches == 0);
    EXPECT_EQ(stage.backend, host ? "tbb" : "opencl") << stage.name;
    EXPECT_EQ(stage.host_reason.empty(), !host) << stage.name;
    EXPECT_EQ(stage.launches > 0, !host) << stage.name;
    EXPECT_EQ(stage.device_seconds > 0, !host) << stage.name;
    if (!host) {
      EXPECT_EQ(stage.device, list_opencl_devices()[0].name) << stage.name;
    }
  }
}

TEST(OpenClConvertAsThePaper, SameSurfaceAsOneTbb) {
  if (list_opencl_devices().empty()) GTEST_SKIP() << "no OpenCL device here";
  const Phantom phantom = make_phantom("y_branch");
  Parameters parameters;
  parameters.stitch = StitchMode::paper;
  const Result got = convert_on("opencl", phantom, parameters);
  const Result want = convert_on("tbb", phantom, parameters);
  ASSERT_GT(want.report.mesh.gap_triangles, 0);
  EXPECT_EQ(got.mesh.vertices, want.mesh.vertices);
  EXPECT_EQ(got.mesh.triangles, want.mesh.triangles);
}

/// On a device of such options, with oneTBB for what it is not given.
Result convert_with(OpenClOptions options, const Phantom& phantom) {
  options.workers = make_tbb_backend(2, nullptr);
  Context context;
  context.backends = {make_opencl_backend(options), options.workers};
  return convert(phantom.view(), {}, context);
}

/// Every other stage on the device: the data cross between the backends' memories at each stage.
TEST(OpenClMixed, SameSurfaceWhateverRunsWhere) {
  if (list_opencl_devices().empty()) GTEST_SKIP() << "no OpenCL device here";
  const Phantom phantom = make_phantom("torus");
  const Result want = convert_on("tbb", phantom);
  for (const std::uint32_t stages : {0x555u, 0xaaau}) {
    for (const DeviceCopies copies :
         {DeviceCopies::shared, DeviceCopies::mapped, DeviceCopies::separate}) {
      OpenClOptions options;
      options.stages = stages;
      options.copies = copies;
      const Result got = convert_with(options, phantom);
      EXPECT_EQ(got.mesh.vertices, want.mesh.vertices);
      EXPECT_EQ(got.mesh.triangles, want.mesh.triangles);
      std::set<std::string> backends;
      for (const StageReport& stage : got.report.stages) {
        backends.insert(stage.backend);
        EXPECT_EQ(stage.host_reason.empty(), stage.backend == "opencl") << stage.name;
      }
      EXPECT_EQ(backends.size(), 2u);
    }
  }
}

/// Devices that are no CPU.
class OpenClOwnMemory : public ::testing::TestWithParam<DeviceCopies> {};

/// What was lent to the device when a conversion stopped is not touched by the next.
TEST_P(OpenClOwnMemory, ServesAgainAfterACancel) {
  if (list_opencl_devices().empty()) GTEST_SKIP() << "no OpenCL device here";
  const Phantom phantom = make_phantom("torus");
  const Result want = convert_on("tbb", phantom);
  OpenClOptions options;
  options.stages = 0x555;
  options.copies = GetParam();
  options.workers = make_tbb_backend(2, nullptr);
  Context context;
  context.backends = {make_opencl_backend(options), options.workers};
  int cancelled = 0;
  for (const int last : {3, 10, 25, 50, 75, 100}) {
    int told = 0;
    context.progress = [&](std::string_view, double) { return ++told < last; };
    try {
      convert(phantom.view(), {}, context);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled);
      ++cancelled;
    }
    context.progress = {};
    const Result got = convert(phantom.view(), {}, context);
    EXPECT_EQ(got.mesh.vertices, want.mesh.vertices);
    EXPECT_EQ(got.mesh.triangles, want.mesh.triangles);
  }
  EXPECT_GT(cancelled, 2);
}

/// What was lent to a pass that was stopped belongs to its owner again: no later command writes it.
TEST_P(OpenClOwnMemory, StoppedPassKeepsNoLoan) {
  if (list_opencl_devices().empty()) GTEST_SKIP() << "no OpenCL device here";
  OpenClOptions options;
  options.copies = GetParam();
  const std::shared_ptr<Backend> backend = make_opencl_backend(options);
  constexpr std::size_t kCount = 400 * kBrickCells;  // more than is copied at once
  std::vector<float> lent(kCount), other(kCount, 2);
  Buffer<float> own(*backend, 1000);
  int told = 0, last = 0;
  backend->set_checkpoint([&] {
    if (++told == last) throw Error(ErrorCode::cancelled, "stopped");
  });
  const auto add = [&] {
    told = 0;
    std::fill(lent.begin(), lent.end(), 1.0f);
    backend->field_add(1, {other.data(), 0, kCount}, {lent.data(), 0, kCount});
  };
  add();
  EXPECT_EQ(lent.back(), 3);
  const int all = told;
  ASSERT_GE(all, GetParam() == DeviceCopies::separate ? 3 : 1);
  for (last = 1; last <= all; ++last) {
    EXPECT_THROW(add(), Error) << last;
    std::fill(lent.begin(), lent.end(), 77.0f);
    backend->fill(own.view(), 0.0f);
    backend->finish();
    EXPECT_TRUE(std::all_of(lent.begin(), lent.end(), [](float x) { return x == 77; })) << last;
  }
}

/// What the host has written reaches a device's own memory, remeshed patches and the front
/// included.
TEST_P(OpenClOwnMemory, SameSurfaceWithHardRegions) {
  if (list_opencl_devices().empty()) GTEST_SKIP() << "no OpenCL device here";
  const Phantom phantom = make_phantom("two_tubes");
  const Result want = convert_on("tbb", phantom);
  ASSERT_GT(want.report.mesh.hard_share, 0);
  OpenClOptions options;
  options.copies = GetParam();
  const Result got = convert_with(options, phantom);
  EXPECT_EQ(got.mesh.vertices, want.mesh.vertices);
  EXPECT_EQ(got.mesh.triangles, want.mesh.triangles);
}

INSTANTIATE_TEST_SUITE_P(Copies, OpenClOwnMemory,
                         ::testing::Values(DeviceCopies::separate, DeviceCopies::mapped));
INSTANTIATE_TEST_SUITE_P(Phantoms, OpenClConvert, ::testing::Values("torus", "y_branch"));

}  // namespace
}  // namespace vasamesh
