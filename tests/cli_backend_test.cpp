/// \file
/// The program and its devices: none, several, a cache that is damaged, cannot be used or is used
/// by two at a time, no linker, Ctrl-C while a device works.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <future>
#include <string>
#include <utility>
#include <vector>

#include "support/environment.h"
#include "support/full_disk.h"
#include "support/scratch.h"
#include "support/spawn.h"

namespace vasamesh {
namespace {

namespace fs = std::filesystem;

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
    unsetenv("POCL_CACHE_DIR");
    fs::create_directories(VASAMESH_CACHE "/tmp");
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

  /// With OpenCL, which is not to be used: one line says why, and oneTBB still does it.
  void expect_refusal(const std::string& why) {
    const Outcome outcome = convert("opencl");
    EXPECT_EQ(outcome.code, 5);
    EXPECT_THAT(outcome.err, HasSubstr(why));
    EXPECT_THAT(outcome.err, HasSubstr("--backend tbb"));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(convert("auto").code, 0);
  }
  static bool has_pocl() { return run({"devices"}).out.find("Portable") != std::string::npos; }

  Scratch folder_;
  const std::string volume_ = folder_ / "sphere.nii.gz";
  /// With what earlier tests have built, so that they need not build it again.
  const Variable cache_{"XDG_CACHE_HOME", VASAMESH_CACHE};
  const Variable temporary_{"TMPDIR", VASAMESH_CACHE "/tmp"};
};

/// Runs the rest as on a machine where OpenCL is not, in one way or another.
class NoOpenCl : public Backends, public testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    Backends::SetUp();
    fs::create_directory(folder_ / "empty");
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
  for (const std::string& folder : {std::string("/proc"), volume_}) {
    const Variable cache("XDG_CACHE_HOME", folder);
    expect_same_bytes();
  }
  const Variable cache("XDG_CACHE_HOME", ""), home("HOME", "");
  expect_same_bytes();
}

TEST_F(Backends, CacheFolderThatIsFull) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  fs::create_directory(folder_ / "full");
  if (mount("tmpfs", (folder_ / "full").c_str(), "tmpfs", 0, "size=1500k") != 0)
    GTEST_SKIP() << "nothing may be mounted here";
  {
    const Variable cache("XDG_CACHE_HOME", folder_ / "full");
    expect_same_bytes();
  }
  EXPECT_EQ(umount((folder_ / "full").c_str()), 0);
}

TEST_F(Backends, NoFolderForPoCL) {
  if (!has_pocl()) GTEST_SKIP() << "no PoCL here";
  for (const std::string& folder : {std::string("/proc"), volume_}) {
    const Variable pocl("POCL_CACHE_DIR", folder);
    expect_refusal(folder + "/vasamesh cannot be made");
  }
  const Variable cache("XDG_CACHE_HOME", volume_);
  const FullDisk full(100000);
  expect_refusal("has room for 97 kB");
}

TEST_F(Backends, ATemporaryFolderOfOthersIsNotUsed) {
  if (!has_pocl()) GTEST_SKIP() << "no PoCL here";
  const Variable cache("XDG_CACHE_HOME", volume_), temporary("TMPDIR", folder_ / "");
  const fs::path own = folder_ / ("vasamesh-" + std::to_string(geteuid()));
  fs::create_directory(own);
  fs::permissions(own, fs::perms::all);
  expect_refusal("set POCL_CACHE_DIR to one that can be written");
  EXPECT_TRUE(fs::is_empty(own));
}

TEST_F(Backends, NoLinkerForPoCL) {
  if (!has_pocl()) GTEST_SKIP() << "no PoCL here";
  const Variable path("PATH", "");
  expect_refusal("needs the linker ld");
}

/// What is kept of PoCL's folder, without files that come and go while other tests use it.
void copy_kernels(const fs::path& from, const fs::path& to) {
  fs::create_directories(to / "files");
  for (const auto& entry : fs::directory_iterator(from))
    if (entry.path().extension() == ".clbin") fs::copy(entry.path(), to / entry.path().filename());
  for (const auto& entry : fs::directory_iterator(from / "files"))
    if (entry.is_directory())
      fs::copy(entry.path(), to / "files" / entry.path().filename(), fs::copy_options::recursive);
}

std::string file_named(const std::string& name, const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().filename() == name) return entry.path();
  return "";
}

TEST_F(Backends, DamagedKernelsAreBuiltAnew) {
  if (!has_pocl()) GTEST_SKIP() << "no PoCL here";
  ASSERT_EQ(convert("opencl").code, 0);
  const fs::path folder = folder_ / "vasamesh/pocl";
  copy_kernels(VASAMESH_CACHE "/vasamesh/pocl", folder);
  const std::string kernel = file_named("primitives_probe.so", folder),
                    program = file_named("program.bc", folder), code = read_text(kernel);
  const Variable cache("XDG_CACHE_HOME", folder_ / "");
  for (const auto& [file, content] : {std::pair(kernel, code.substr(0, 100)),
                                      {kernel, code.substr(0, code.size() / 2)},
                                      {program, std::string(100000, 'x')},
                                      {program, std::string()}}) {
    SCOPED_TRACE(file + ", bytes: " + std::to_string(content.size()));
    write_text(file, content);
    expect_same_bytes();
    EXPECT_TRUE(read_text(file) != content);
  }
}

TEST_F(Backends, TwoProcessesShareAColdCache) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  const Variable cache("XDG_CACHE_HOME", folder_ / "cache");
  auto other = std::async(std::launch::async, [&] { return convert("opencl", "other.ply"); });
  expect_same_bytes();
  EXPECT_EQ(other.get().code, 0);
  EXPECT_TRUE(read_text(folder_ / "other.ply") == read_text(folder_ / "tbb.ply"));
  expect_same_bytes();
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
