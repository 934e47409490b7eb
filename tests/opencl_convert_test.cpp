/// A conversion with the OpenCL backend gives the surface of one without, byte by byte.

#include <gtest/gtest.h>

#include <algorithm>

#include "opencl/backend.h"
#include "phantom/phantom.h"
#include "vasamesh/host.h"
#include "vasamesh/pipeline.h"

namespace vasamesh {
namespace {

Result convert_on(const std::string& backend, const Phantom& phantom) {
  ContextOptions options;
  options.backend = backend;
  options.threads = 2;
  Context context = make_context(options);
  return convert(phantom.view(), {}, context);
}

class OpenClConvert : public ::testing::TestWithParam<const char*> {};

TEST_P(OpenClConvert, SameSurfaceAsOneTbb) {
  if (list_opencl_devices().empty()) GTEST_SKIP() << "no OpenCL device here";
  const Phantom phantom = make_phantom(GetParam());
  const Result got = convert_on("opencl", phantom), want = convert_on("tbb", phantom);
  ASSERT_GT(want.mesh.triangle_count(), 0u);
  EXPECT_EQ(got.mesh.vertices, want.mesh.vertices);
  EXPECT_EQ(got.mesh.triangles, want.mesh.triangles);
  const auto solve = std::find_if(got.report.stages.begin(), got.report.stages.end(),
                                  [](const StageReport& stage) { return stage.name == "poisson"; });
  ASSERT_NE(solve, got.report.stages.end());
  EXPECT_EQ(solve->backend, "opencl");
  EXPECT_EQ(solve->device, list_opencl_devices()[0].name);
}

INSTANTIATE_TEST_SUITE_P(Phantoms, OpenClConvert, ::testing::Values("torus", "y_branch"));

}  // namespace
}  // namespace vasamesh
