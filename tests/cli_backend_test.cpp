/// \file
/// The program and its devices: none, several, a cache that cannot be used or is used by two at a
/// time, Ctrl-C while a device works.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <future>
#include <string>
#include <vector>

#include "support/environment.h"
#include "support/scratch.h"
#include "support/spawn.h"

namespace vasamesh {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

Outcome run(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), VASAMESH_PROGRAM);
  return run_program(arguments);
}

class Backends : public testing::Test {
 protected:
  void SetUp() override {
    unsetenv("VASAMESH_DEVICE");
    ASSERT_EQ(run({"phantom", "sphere", "--radius", "3", "-o", volume_}).code, 0);
  }
  Outcome convert(const std::string& backend, const std::string& surface = "surface.ply") {
    return run({"convert", volume_, "-o", folder_ / surface, "--backend", backend});
  }
  /// With OpenCL, where the conversion must give what oneTBB gives.
  void expect_same_bytes() {
    const Outcome outcome = convert("opencl", "opencl.ply");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(convert("tbb", "tbb.ply").code, 0);
    EXPECT_TRUE(read_text(folder_ / "opencl.ply") == read_text(folder_ / "tbb.ply"));
  }
  static bool has_opencl() { return run({"devices"}).out.find("opencl") != std::string::npos; }

  /// PoCL's own cache: without one that it can write, PoCL is no device.
  const Variable pocl_{"POCL_CACHE_DIR", VASAMESH_POCL_CACHE};
  Scratch folder_;
  const std::string volume_ = folder_ / "sphere.nii.gz";
};

/// Runs the rest as on a machine where OpenCL is not, in one way or another.
class NoOpenCl : public Backends, public testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    Backends::SetUp();
    std::filesystem::create_directory(folder_ / "empty");
    write_text(folder_ / "libOpenCL.so.1", "no loader");
  }
  std::string value() const {
    return GetParam() == std::string("LD_LIBRARY_PATH") ? folder_ / "" : folder_ / "empty";
  }
};

TEST_P(NoOpenCl, IsSaidAndOnlyTbbIsListed) {
  const Variable without(GetParam(), value());
  const Outcome devices = run({"devices"});
  EXPECT_EQ(devices.code, 0);
  EXPECT_THAT(devices.out, Not(HasSubstr("opencl")));
  const Outcome refused = convert("opencl");
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.err, HasSubstr("--backend tbb"));
  EXPECT_EQ(convert("auto").code, 0);
  EXPECT_EQ(convert("tbb").code, 0);
}

// No loader; a loader without platforms.
INSTANTIATE_TEST_SUITE_P(Ways, NoOpenCl, testing::Values("LD_LIBRARY_PATH", "OCL_ICD_VENDORS"));

TEST_F(Backends, NamesThatFitNothingAreRefused) {
  const Outcome option =
      run({"convert", volume_, "-o", folder_ / "surface.ply", "--device", "no such device"});
  EXPECT_EQ(option.code, 5);
  EXPECT_THAT(option.err, HasSubstr("--device: \"no such device\" fits no device"));
  const Variable device("VASAMESH_DEVICE", "no such device");
  const Outcome variable = convert("auto");
  EXPECT_EQ(variable.code, 5);
  EXPECT_THAT(variable.err, HasSubstr("VASAMESH_DEVICE: \"no such device\" fits no device"));
  EXPECT_THAT(folder_.names(), ElementsAre("sphere.nii.gz"));
}

TEST_F(Backends, CacheFolderThatCannotBeWritten) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  for (const char* folder : {"/proc", "/dev/null"}) {
    const Variable cache("XDG_CACHE_HOME", folder);
    expect_same_bytes();
  }
}

TEST_F(Backends, TwoProcessesShareAColdCache) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  const Variable cache("XDG_CACHE_HOME", folder_ / "cache");
  std::filesystem::create_directory(folder_ / "pocl");
  const Variable pocl("POCL_CACHE_DIR", folder_ / "pocl");
  auto other = std::async(std::launch::async, [&] { return convert("opencl", "other.ply"); });
  expect_same_bytes();
  EXPECT_EQ(other.get().code, 0);
  EXPECT_TRUE(read_text(folder_ / "other.ply") == read_text(folder_ / "tbb.ply"));
}

TEST_F(Backends, CtrlCWhileADeviceWorksLeavesTheOldFile) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  const std::string scan = folder_ / "aorta.nii.gz", surface = folder_ / "aorta.ply";
  ASSERT_EQ(run({"phantom", "aorta", "-o", scan}).code, 0);
  write_text(surface, "an old surface");
  for (const char* stage : {"points", "normals", "octree", "poisson", "topology", "surface"}) {
    SCOPED_TRACE(stage);
    const Outcome outcome =
        interrupt_program({VASAMESH_PROGRAM, "convert", scan, "-o", surface, "--backend", "opencl"},
                          std::string("%  ") + stage, SIGINT);
    EXPECT_EQ(outcome.code, 130);
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(folder_.names(), ElementsAre("aorta.nii.gz", "aorta.ply", "sphere.nii.gz"));
    EXPECT_EQ(read_text(surface), "an old surface");
  }
}

}  // namespace
}  // namespace vasamesh
