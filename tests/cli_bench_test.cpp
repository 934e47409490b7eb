/// \file
/// `vasamesh bench`: every stage once a way, shares that add up, the backend that was asked for.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "support/scratch.h"
#include "support/spawn.h"

namespace vasamesh {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

class Bench : public testing::Test {
 protected:
  Bench() { run({"phantom", "sphere", "--radius", "4", "-o", volume_}); }

  static Outcome run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), VASAMESH_PROGRAM);
    return run_program(arguments);
  }
  json bench(std::vector<std::string> options) const {
    options.insert(options.begin(), {"bench", volume_, "--repeat", "1", "--json"});
    const Outcome outcome = run(options);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return json::parse(outcome.out)[0];
  }

  Scratch folder_;
  const std::string volume_ = folder_ / "sphere.nii.gz";
};

TEST_F(Bench, EveryStageOnEveryNumberOfThreads) {
  const json table = bench({"--backends", "tbb", "--threads", "1,2"});
  EXPECT_GT(table["object_voxels"], 200);
  ASSERT_EQ(table["runs"].size(), 2u);
  // What the making of the adaptive surface must move depends on the surface.
  const std::set<std::string> uncounted = {"sizes",  "remesh", "expand",
                                           "stitch", "finish", "settle"};
  for (const json& run : table["runs"]) {
    std::vector<std::string> names;
    double seconds = 0;
    for (const json& stage : run["stages"]) {
      names.push_back(stage["name"]);
      seconds += stage["seconds"].get<double>();
      EXPECT_EQ(stage["backend"], "tbb");
      EXPECT_EQ(stage["agrees"], true) << stage;
      if (!uncounted.contains(stage["name"])) {
        EXPECT_GT(stage["bytes"], 0) << stage;
      }
    }
    EXPECT_THAT(names, ElementsAre("input", "points", "normals", "octree", "poisson", "topology",
                                   "surface", "sizes", "remesh", "expand", "stitch", "finish",
                                   "settle", "check", "quality"));
    EXPECT_NEAR(seconds, run["seconds"].get<double>(), 1e-6 + 1e-3 * seconds);
    EXPECT_GT(run["bandwidth"], 1e8);
    EXPECT_GT(run["arithmetic"], 1e8);
    EXPECT_GT(run["bytes_peak"], 10000);
  }
}

TEST_F(Bench, ADeviceIsWhatRanAndAgrees) {
  if (run({"devices"}).out.find("opencl") == std::string::npos) GTEST_SKIP() << "no OpenCL device";
  const json table = bench({"--threads", "1"});
  ASSERT_GE(table["runs"].size(), 2u);
  const json& device = table["runs"].back();
  EXPECT_EQ(device["failure"], "");
  std::int64_t launches = 0;
  for (const json& stage : device["stages"]) {
    EXPECT_EQ(stage["agrees"], true) << stage;
    launches += stage["launches"].get<std::int64_t>();
    if (stage["name"] == "poisson") {
      EXPECT_EQ(stage["backend"], "opencl");
    }
  }
  EXPECT_GT(launches, 100);
}

TEST_F(Bench, AFileNameNeedNotBeUtf8) {
  const std::string volume = folder_ / "\xff.nii.gz";
  std::filesystem::copy_file(volume_, volume);
  const Outcome outcome =
      run({"bench", volume, "--repeat", "1", "--json", "--backends", "tbb", "--threads", "1"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)[0]["input"], folder_ / "\uFFFD.nii.gz");
}

TEST_F(Bench, TheTableIsForPeople) {
  const Outcome outcome =
      run({"bench", volume_, volume_, "--backends", "tbb", "--threads", "1", "--repeat", "1"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("tbb 1: "));
  EXPECT_THAT(outcome.out, HasSubstr("topology"));
  EXPECT_THAT(outcome.out, HasSubstr("times tbb 1"));
}

TEST_F(Bench, WrongUse) {
  EXPECT_EQ(run({"bench"}).code, 2);
  EXPECT_EQ(run({"bench", volume_, "--backends", "cuda"}).code, 2);
  EXPECT_EQ(run({"bench", volume_, "--repeat", "0"}).code, 2);
  EXPECT_EQ(run({"bench", volume_, "--device", "99", "--threads", "1"}).code, 5);
  EXPECT_EQ(run({"bench", folder_ / "none.nii.gz", "--threads", "1", "--backends", "tbb"}).code, 3);
}

}  // namespace
}  // namespace vasamesh
