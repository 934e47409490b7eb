/// \file
/// The program at work: phantoms made, converted and checked; what goes to which stream; what
/// Ctrl-C leaves behind.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "support/scratch.h"
#include "support/spawn.h"

namespace vasamesh {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

using Arguments = std::vector<std::string>;

Arguments command(Arguments arguments) {
  arguments.insert(arguments.begin(), VASAMESH_PROGRAM);
  return arguments;
}

/// Runs the program and expects success without a word on stderr. \return its stdout.
std::string run(const Arguments& arguments) {
  const Outcome outcome = run_program(command(arguments));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  return outcome.out;
}

TEST(Phantom, SaysWhatItWrote) {
  const Scratch folder;
  const std::string out =
      run({"phantom", "torus", "-o", folder / "torus.nii.gz", "--surface", folder / "torus.ply"});
  EXPECT_THAT(out, HasSubstr("torus.nii.gz: "));
  EXPECT_THAT(out, HasSubstr("torus.ply: "));
  EXPECT_THAT(folder.names(), ElementsAre("torus.nii.gz", "torus.ply"));
}

TEST(Check, ATorusHasOneHandle) {
  const Scratch folder;
  run({"phantom", "torus", "-o", folder / "torus.nii.gz", "--surface", folder / "torus.ply"});
  EXPECT_THAT(run({"check", folder / "torus.ply"}), HasSubstr("1 piece, 1 handle, 0 cavities"));
  const json report = json::parse(
      run({"check", folder / "torus.ply", "--against", folder / "torus.nii.gz", "--json"}));
  EXPECT_EQ(report["schema_version"], 1);
  EXPECT_EQ(report["check"]["passed"], true);
  EXPECT_EQ(report["check"]["wanted"]["handles"], 1);
  EXPECT_LT(report["distance"]["to"]["mean_voxels"], 0.27);
  EXPECT_GT(report["distance"]["to"]["mean_voxels"], 0.0);
}

TEST(Check, ASurfaceOfAnotherSolidFails) {
  const Scratch folder;
  run({"phantom", "torus", "-o", folder / "torus.nii.gz", "--surface", folder / "torus.ply"});
  run({"phantom", "sphere", "-o", folder / "sphere.nii.gz"});
  const Outcome outcome =
      run_program(command({"check", folder / "torus.ply", "--against", folder / "sphere.nii.gz"}));
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.out, HasSubstr("failed"));
  EXPECT_THAT(outcome.err, HasSubstr("torus.ply"));
}

TEST(Check, ASurfaceHasNoDistanceToItself) {
  const Scratch folder;
  run({"phantom", "sphere", "--radius", "4", "-o", folder / "sphere.nii.gz", "--surface",
       folder / "sphere.ply"});
  const json report = json::parse(
      run({"check", folder / "sphere.ply", "--reference", folder / "sphere.ply", "--json"}));
  EXPECT_LT(report["distance"]["to"]["maximum_mm"], 1e-5);
  EXPECT_LT(report["distance"]["back"]["maximum_mm"], 1e-5);
  EXPECT_EQ(report["distance"]["reference_triangles"], report["check"]["triangles"]);
  EXPECT_FALSE(report["distance"].contains("voxel_mm"));
}

TEST(Check, SurfaceAndReferenceMayLieInDifferentSpaces) {
  const Scratch folder;
  run({"phantom", "tree", "--spacing", "0.5", "0.5", "0.8", "-o", folder / "tree.nii.gz"});
  for (const char* space : {"lps", "ras", "voxel"})
    run({"convert", folder / "tree.nii.gz", "-o", folder / space + ".ply", "--space", space});
  for (const auto& [surface, reference] :
       {std::pair("lps.ply", "ras.ply"), {"ras.ply", "lps.ply"}, {"ras.ply", "ras.ply"}}) {
    const json report =
        json::parse(run({"check", folder / surface, "--reference", folder / reference, "--json"}));
    EXPECT_LT(report["distance"]["to"]["maximum_mm"], 1e-3) << surface << " " << reference;
  }
  for (const auto& [surface, reference] :
       {std::pair("voxel.ply", "ras.ply"), {"lps.ply", "voxel.ply"}}) {
    const Arguments check = {"check", folder / surface, "--reference", folder / reference,
                             "--json"};
    const Outcome outcome = run_program(command(check));
    EXPECT_EQ(outcome.code, 2) << surface << " " << reference;
    EXPECT_THAT(outcome.err, HasSubstr("--against"));
    Arguments with_volume = check;
    with_volume.insert(with_volume.end(), {"--against", folder / "tree.nii.gz"});
    const json report = json::parse(run(with_volume));
    EXPECT_LT(report["distance"]["to"]["maximum_mm"], 1e-3) << surface << " " << reference;
  }
}

TEST(Check, SurfacesThatLieApartAreTold) {
  const Scratch folder;
  run({"phantom", "sphere", "--radius", "3", "-o", folder / "sphere.nii", "--surface",
       folder / "sphere.ply"});
  write_text(
      folder / "far.obj",
      "v 1000 0 0\nv 1001 0 0\nv 1000 1 0\nv 1000 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  const Outcome apart =
      run_program(command({"check", folder / "sphere.ply", "--reference", folder / "far.obj"}));
  EXPECT_THAT(apart.err, HasSubstr("lie apart"));
  const Outcome together =
      run_program(command({"check", folder / "sphere.ply", "--reference", folder / "sphere.ply"}));
  EXPECT_EQ(together.err, "");
}

/// It gives no length for the samples' distance.
TEST(Check, AReferenceWithoutAreaIsRefused) {
  const Scratch folder;
  run({"phantom", "sphere", "--radius", "3", "-o", folder / "sphere.nii", "--surface",
       folder / "sphere.ply"});
  write_text(folder / "line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  const Outcome outcome =
      run_program(command({"check", folder / "sphere.ply", "--reference", folder / "line.obj"}));
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("has no area"));
}

TEST(Check, AFileNameNeedNotBeUtf8) {
  const Scratch folder;
  const std::string surface = folder / "bad\xff\xfe.ply";
  run({"phantom", "sphere", "--radius", "3", "-o", folder / "sphere.nii", "--surface", surface});
  const json report = json::parse(run({"check", surface, "--json"}));
  EXPECT_EQ(report["surface"], folder / "bad\uFFFD\uFFFD.ply");
}

TEST(Check, WritesAMapOfCurvatures) {
  const Scratch folder;
  run({"phantom", "sphere", "--radius", "6", "--spacing", "0.5", "0.5", "0.5", "-o",
       folder / "sphere.nii.gz", "--surface", folder / "sphere.ply"});
  const json report =
      json::parse(run({"check", folder / "sphere.ply", "--json", "--map", folder / "map.vtp"}));
  EXPECT_NEAR(report["rms_curvature"]["mean"], 1 / 3.0, 0.1 / 3);
  const std::string map = read_text(folder / "map.vtp");
  for (const char* name : {"rms_curvature", "kmax", "kmin", "area", "edge_ratio", "least_angle"})
    EXPECT_THAT(map, HasSubstr(std::string("Name=\"") + name + "\""));
  EXPECT_EQ(run_program(command({"check", folder / "sphere.ply", "--map", folder / "a.txt"})).code,
            2);
}

class Convert : public testing::Test {
 protected:
  Convert() { run({"phantom", "torus", "-o", volume_}); }

  Scratch folder_;
  const std::string volume_ = folder_ / "torus.nii.gz";
};

TEST_F(Convert, EachFormatPassesItsCheck) {
  for (const char* name : {"torus.vtp", "torus.stl", "torus.ply", "torus.obj"}) {
    EXPECT_THAT(run({"convert", volume_, "-o", folder_ / name}), HasSubstr(name));
    run({"check", folder_ / name, "--against", volume_});
  }
}

TEST_F(Convert, AReportMayHaveAnyEnding) {
  for (const char* name : {"report.gz", ".gz", "report", "report.json.gz"}) {
    run({"convert", volume_, "-o", folder_ / "torus.ply", "--report", folder_ / name});
    EXPECT_TRUE(json::parse(read_text(folder_ / name)).contains("stages")) << name;
  }
}

TEST_F(Convert, EachSpacePassesItsCheck) {
  for (const char* space : {"lps", "ras", "voxel"}) {
    run({"convert", volume_, "-o", folder_ / "torus.ply", "--space", space});
    const json report = json::parse(
        run({"check", folder_ / "torus.ply", "--against", volume_, "--space", space, "--json"}));
    EXPECT_LT(report["distance"]["to"]["mean_voxels"], 0.27) << space;
  }
}

TEST_F(Convert, TheCheckKnowsTheSpaceThatTheFileIsIn) {
  for (const char* name : {"torus.vtp", "torus.stl", "torus.ply", "torus.obj"})
    for (const char* space : {"ras", "voxel"}) {
      SCOPED_TRACE(std::string(name) + " " + space);
      const std::string surface = folder_ / name;
      run({"convert", volume_, "-o", surface, "--space", space, "--surface", "base"});
      const json report = json::parse(run({"check", surface, "--against", volume_, "--json"}));
      EXPECT_LT(report["distance"]["to"]["mean_voxels"], 0.27);
    }
}

TEST_F(Convert, AnotherSpaceThanTheFilesIsToldOf) {
  const std::string surface = folder_ / "torus.ply";
  run({"convert", volume_, "-o", surface, "--space", "voxel"});
  run({"check", surface, "--against", volume_, "--space", "voxel"});
  const Outcome outcome =
      run_program(command({"check", surface, "--against", volume_, "--space", "ras"}));
  EXPECT_EQ(outcome.err.find("vasamesh: " + surface + " says that it is in voxel, and is taken"),
            0u)
      << outcome.err;
}

TEST_F(Convert, ReportNamesStagesAndTopology) {
  run({"convert", volume_, "-o", folder_ / "torus.vtp", "--report", folder_ / "torus.json",
       "--backend", "tbb"});
  const json report = json::parse(read_text(folder_ / "torus.json"));
  EXPECT_EQ(report["schema_version"], 1);
  EXPECT_EQ(report["check"]["topology"]["handles"], 1);
  EXPECT_EQ(report["check"]["passed"], true);
  const json& stages = report["stages"];
  ASSERT_GT(stages.size(), 2u);
  EXPECT_EQ(stages[0]["name"], "device");
  EXPECT_EQ(stages[1]["name"], "read");
  EXPECT_EQ(stages.back()["name"], "write");
  for (const json& stage : stages) {
    EXPECT_GE(stage["seconds"], 0.0);
    EXPECT_EQ(stage["host_reason"], "") << stage["name"];  // no device was there to be left
  }
}

TEST_F(Convert, AnAdaptiveSurfaceSaysHowItWasMade) {
  const std::string out = run({"convert", volume_, "-o", folder_ / "torus.ply"});
  EXPECT_THAT(out, HasSubstr("as the segmentation"));
  EXPECT_THAT(out, HasSubstr("\nMesh      "));
  EXPECT_THAT(out, HasSubstr("by the front"));
  run({"check", folder_ / "torus.ply", "--against", volume_});
  EXPECT_THAT(run({"convert", volume_, "-o", folder_ / "torus.ply", "--surface", "base"}),
              Not(HasSubstr("\nMesh")));
}

TEST_F(Convert, OptionsBesideAPresetWin) {
  const Arguments preset = {"--preset", "simulator"}, rho = {"--rho", "0.5"};
  for (const bool preset_first : {true, false}) {
    Arguments arguments = {
        "convert", volume_, "-o", folder_ / "torus.vtp", "--report", folder_ / "torus.json"};
    for (const Arguments& part : {preset_first ? preset : rho, preset_first ? rho : preset})
      arguments.insert(arguments.end(), part.begin(), part.end());
    run(arguments);
    const json parameters = json::parse(read_text(folder_ / "torus.json"))["parameters"];
    EXPECT_EQ(parameters["rho"], 0.5);
    EXPECT_EQ(parameters["edge_max"], 3.0);
    EXPECT_EQ(parameters["surface"], "adaptive");
  }
}

/// Runs the program and expects it to refuse, with code 2, what `option` names.
void expect_not_distinct(const Arguments& arguments, const std::string& option) {
  const Outcome outcome = run_program(command(arguments));
  EXPECT_EQ(outcome.code, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("vasamesh: " + option + " names "));
  EXPECT_EQ(outcome.out, "");
}

TEST_F(Convert, OutputsMustNotReplaceInputsOrEachOther) {
  std::filesystem::create_hard_link(volume_, folder_ / "hard");
  std::filesystem::create_symlink("torus.nii.gz", folder_ / "soft");
  std::filesystem::create_symlink("torus.ply", folder_ / "early");
  std::filesystem::create_directory_symlink(".", folder_ / "same");
  const std::string bytes = read_text(volume_);
  const std::vector<std::string> names = folder_.names();
  for (const char* report : {"torus.nii.gz", "./torus.nii.gz", "same/torus.nii.gz", "hard", "soft",
                             "torus.ply", "./torus.ply", "same/./torus.ply", "early"}) {
    SCOPED_TRACE(report);
    expect_not_distinct(
        {"convert", volume_, "-o", folder_ / "torus.ply", "--report", folder_ / report},
        "--report");
  }
  EXPECT_EQ(folder_.names(), names);
  EXPECT_EQ(read_text(volume_), bytes);
}

TEST_F(Convert, OutputsMustNotReplaceVoxelsInAFileOfTheirOwn) {
  write_text(folder_ / "a.raw", std::string("\0\1\1\0", 4));
  write_text(folder_ / "a.mhd",
             "NDims = 3\nDimSize = 2 2 1\nElementType = MET_UCHAR\nElementDataFile = a.raw\n");
  write_text(folder_ / "a.nrrd",
             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 1\nencoding: raw\n"
             "data file: a.raw\n\n");
  for (const char* name : {"a.mhd", "a.nrrd"})
    expect_not_distinct(
        {"convert", folder_ / name, "-o", folder_ / "a.ply", "--report", folder_ / "a.raw"},
        "--report");
}

TEST_F(Convert, OutputsMustNotReplaceSlices) {
  std::filesystem::create_directory(folder_ / "series");
  write_text(folder_ / "series/1.dcm", "a slice");
  write_text(folder_ / "series/old.json", "{}");
  std::filesystem::create_symlink("series/1.dcm", folder_ / "link.ply");
  std::filesystem::create_hard_link(folder_ / "series/1.dcm", folder_ / "hard.dcm");
  const auto with_report = [&](const char* name) {
    return Arguments{"convert",         folder_ / "series", "-o",
                     folder_ / "a.ply", "--report",         folder_ / name};
  };
  for (const char* name : {"series/1.dcm", "link.ply", "hard.dcm"})
    expect_not_distinct(with_report(name), "--report");
  expect_not_distinct({"convert", folder_ / "series/", "-o", folder_ / "link.ply"}, "--output");
  EXPECT_EQ(read_text(folder_ / "series/1.dcm"), "a slice");
  for (const char* name : {"series/new.json", "series/old.json"})  // as far as the bad slice
    EXPECT_EQ(run_program(command(with_report(name))).code, 3) << name;
}

TEST(Check, AMapMustNotReplaceWhatIsChecked) {
  const Scratch folder;
  write_text(folder / "a.vtp", "a surface");
  write_text(folder / "b.ply", "another");
  std::filesystem::create_symlink("a.vtp", folder / "link.vtp");
  for (const char* map : {"a.vtp", "link.vtp"}) {
    expect_not_distinct({"check", folder / "a.vtp", "--map", folder / map}, "--map");
    expect_not_distinct(
        {"check", folder / "b.ply", "--reference", folder / "a.vtp", "--map", folder / map},
        "--map");
    expect_not_distinct(
        {"check", folder / "b.ply", "--against", folder / "a.vtp", "--map", folder / map}, "--map");
  }
  EXPECT_EQ(read_text(folder / "a.vtp"), "a surface");
}

TEST(Phantom, ItsSurfaceMustNotReplaceItsVolume) {
  const Scratch folder;
  std::filesystem::create_symlink("torus.nii", folder / "torus.ply");
  expect_not_distinct(
      {"phantom", "torus", "-o", folder / "torus.nii", "--surface", folder / "torus.ply"},
      "--surface");
  EXPECT_THAT(folder.names(), ElementsAre("torus.ply"));
}

/// A block of 10 x 10 x 10 voxels without one in its middle.
std::string block_with_a_cavity() {
  constexpr int kSide = 12;
  std::string voxels(kSide * kSide * kSide, '\0');
  for (int z = 1; z < kSide - 1; ++z)
    for (int y = 1; y < kSide - 1; ++y)
      for (int x = 1; x < kSide - 1; ++x)
        voxels[static_cast<std::size_t>(x + kSide * (y + kSide * z))] = 1;
  voxels[6 + kSide * (6 + kSide * 6)] = 0;
  return "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 12 12 12\nspacings: 1 1 1\n"
         "encoding: raw\n\n" +
         voxels;
}

TEST(Closing, TheProofSaysWhatWasClosed) {
  const Scratch folder;
  write_text(folder / "block.nrrd", block_with_a_cavity());
  Arguments arguments = {"convert", folder / "block.nrrd", "-o", folder / "block.ply"};
  EXPECT_THAT(run(arguments), HasSubstr("1 cavity, as the segmentation;"));
  arguments.push_back("--close-handles");
  EXPECT_THAT(run(arguments),
              HasSubstr("0 cavities, as the segmentation but for 1 cavity closed;"));
}

TEST_F(Convert, TheSameBytesWithAnyNumberOfThreads) {
  std::vector<std::string> surfaces;
  for (const char* threads : {"1", "2", "4", "4096"}) {
    run({"convert", volume_, "-o", folder_ / "torus.ply", "--threads", threads});
    surfaces.push_back(read_text(folder_ / "torus.ply"));
  }
  EXPECT_FALSE(surfaces[0].empty());
  for (const std::string& surface : surfaces) EXPECT_TRUE(surface == surfaces[0]);
}

TEST_F(Convert, StartsAtMostFourThreadsForEachProcessor) {
  const int most = 4 * static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  for (const int asked : {most - 1, most, most + 1, 4096}) {
    run({"convert", volume_, "-o", folder_ / "torus.ply", "--backend", "tbb", "--report",
         folder_ / "torus.json", "--threads", std::to_string(asked)});
    const json stages = json::parse(read_text(folder_ / "torus.json"))["stages"];
    EXPECT_EQ(stages[2]["device"], "CPU, " + std::to_string(std::min(asked, most)) + " threads");
  }
}

TEST_F(Convert, TheBackendAskedForRunsAndGivesTheSameBytes) {
  if (run({"devices"}).find("opencl") == std::string::npos) GTEST_SKIP() << "no OpenCL device";
  for (const char* backend : {"tbb", "opencl"})
    run({"convert", volume_, "-o", folder_ / backend + std::string(".ply"), "--backend", backend,
         "--report", folder_ / backend});
  const json stages = json::parse(read_text(folder_ / "opencl"))["stages"];
  const auto poisson = std::find_if(stages.begin(), stages.end(),
                                    [](const json& stage) { return stage["name"] == "poisson"; });
  ASSERT_NE(poisson, stages.end());
  EXPECT_EQ((*poisson)["backend"], "opencl");
  EXPECT_TRUE(read_text(folder_ / "tbb.ply") == read_text(folder_ / "opencl.ply"));
}

TEST_F(Convert, QuietSaysNothingAtAll) {
  const Outcome outcome =
      run_on_terminal(command({"convert", volume_, "-o", folder_ / "torus.vtp", "--quiet"}));
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err, "");
}

TEST_F(Convert, TheBarIsForTerminalsAlone) {
  const Outcome outcome =
      run_on_terminal(command({"convert", volume_, "-o", folder_ / "torus.vtp"}));
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("%  read"));
  EXPECT_THAT(outcome.out, HasSubstr("torus.vtp"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("%  ")));
}

/// By signal, sent while the volume is read and while the stages run.
class Interrupted : public testing::TestWithParam<int> {};

TEST_P(Interrupted, ConversionLeavesTheOldFile) {
  const Scratch folder;
  run({"phantom", "aorta", "-o", folder / "aorta.nii.gz"});
  write_text(folder / "aorta.vtp", "an old surface");
  signal(GetParam(), SIG_DFL);  // nohup would have it ignored
  const Outcome outcome =
      interrupt_program(command({"convert", folder / "aorta.nii.gz", "-o", folder / "aorta.vtp",
                                 "--report", folder / "aorta.json"}),
                        "%  read", GetParam());
  EXPECT_EQ(outcome.code, 130);
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(folder.names(), ElementsAre("aorta.nii.gz", "aorta.vtp"));
  EXPECT_EQ(read_text(folder / "aorta.vtp"), "an old surface");
}

INSTANTIATE_TEST_SUITE_P(Signals, Interrupted, testing::Values(SIGINT, SIGTERM, SIGHUP));

/// The program, started by a shell after `preparation`.
Arguments in_shell(const std::string& preparation, const Arguments& arguments) {
  Arguments all = {"/bin/sh", "-c", preparation + "; exec \"$@\"", "sh"};
  for (const std::string& argument : command(arguments)) all.push_back(argument);
  return all;
}

/// As under nohup, or in the background of a script.
TEST_F(Convert, GoesOnAtSignalsThatAreIgnored) {
  const Arguments arguments = {"convert", volume_, "-o", folder_ / "torus.ply"};
  for (const int signal : {SIGHUP, SIGINT}) {
    const Outcome outcome =
        interrupt_program(in_shell("trap '' HUP INT", arguments), "%  read", signal);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_THAT(folder_.names(), ElementsAre("torus.nii.gz", "torus.ply"));
  }
}

/// A tetrahedron of doubles that float32 makes flat.
TEST(Check, SaysThatASurfaceFarOutIsRounded) {
  const Scratch folder;
  const auto tetrahedron = [&](const std::string& x) {
    write_text(folder / "far.obj", "v " + x + ".00 0 0\nv " + x + ".01 0 0\nv " + x +
                                       ".00 1 0\nv " + x +
                                       ".00 0 1\n"
                                       "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    return run_program(command({"check", folder / "far.obj"}));
  };
  EXPECT_EQ(tetrahedron("10").code, 0);
  const Outcome far = tetrahedron("1000000");
  EXPECT_EQ(far.code, 4);
  EXPECT_THAT(far.err, HasSubstr("2 degenerate triangles"));
  EXPECT_THAT(far.err,
              HasSubstr("float32 coordinates, to which it is rounded, are 0.062 mm apart"));
  EXPECT_EQ(std::count(far.err.begin(), far.err.end(), '\n'), 1) << far.err;
}

/// Where it is met, in a thread of oneTBB's among others, depends on the machine.
TEST(Check, ALimitOfMemoryIsToldAsOne) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer's own memory is beyond each limit";
#endif
  const Scratch folder;
  run({"phantom", "sphere", "--radius", "5", "-o", folder / "sphere.nii", "--surface",
       folder / "sphere.ply"});
  for (int kilobytes = 80'000; kilobytes <= 120'000; kilobytes += 4'000) {
    const Outcome outcome =
        run_program(in_shell("ulimit -v " + std::to_string(kilobytes),
                             {"check", folder / "sphere.ply", "--threads", "8"}));
    if (outcome.code == 0 || outcome.code == 127) continue;  // 127: its libraries do not fit
    EXPECT_EQ(outcome.code, 6) << kilobytes;
    EXPECT_THAT(outcome.err, HasSubstr("memory")) << kilobytes;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

TEST_F(Convert, ALimitOfAFilesSizeIsAFullDisk) {
  write_text(folder_ / "torus.ply", "an old surface");
  const Arguments arguments = {"convert", volume_, "-o", folder_ / "torus.ply"};
  const Outcome outcome = run_program(in_shell("ulimit -f 1", arguments));
  EXPECT_EQ(outcome.code, 6);
  EXPECT_THAT(outcome.err, HasSubstr("could not be written"));
  EXPECT_THAT(folder_.names(), ElementsAre("torus.nii.gz", "torus.ply"));
  EXPECT_EQ(read_text(folder_ / "torus.ply"), "an old surface");
}

}  // namespace
}  // namespace vasamesh
