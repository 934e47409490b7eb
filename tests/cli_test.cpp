/// \file
/// The command line: help, wrong use and bad input, each with its exit code and its one line on
/// stderr. Whatever goes wrong, an old output file stays as it was.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "support/scratch.h"
#include "support/spawn.h"

namespace vasamesh {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

using Arguments = std::vector<std::string>;

Outcome vasamesh_with(Arguments arguments, const std::string& stdout_to = {}) {
  arguments.insert(arguments.begin(), VASAMESH_PROGRAM);
  return run_program(arguments, stdout_to);
}

/// A NRRD file of `sizes` voxels, 4 x 4 x 4 unless said otherwise.
std::string nrrd(const std::string& type, const std::string& bytes,
                 const std::string& sizes = "4 4 4", const std::string& spacings = "1 1 1") {
  return "NRRD0004\ntype: " + type + "\ndimension: 3\nsizes: " + sizes + "\nspacings: " + spacings +
         "\nendian: little\nencoding: raw\n\n" + bytes;
}

/// The bytes of 64 values: `first`, then zeros.
template <class Value>
std::string voxels(std::vector<Value> first) {
  first.resize(64);
  return {reinterpret_cast<const char*>(first.data()), 64 * sizeof(Value)};
}

/// The inputs of the tests below, good and bad.
void make_inputs(const Scratch& folder) {
  using Bytes = std::vector<unsigned char>;
  using Floats = std::vector<float>;
  Floats ramp;
  for (int i = 0; i < 64; ++i) ramp.push_back(static_cast<float>(i) + 0.5f);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  write_text(folder / "good.nrrd", nrrd("uchar", voxels(Bytes{1, 1})));
  write_text(folder / "empty.nrrd", nrrd("uchar", voxels(Bytes{})));
  write_text(folder / "labels.nrrd", nrrd("short", voxels(std::vector<short>{3, 7})));
  write_text(folder / "grey.nrrd", nrrd("float", voxels(ramp)));
  write_text(folder / "nan.nrrd", nrrd("float", voxels(Floats{1, nan})));
  write_text(folder / "huge.nrrd", nrrd("uchar", voxels(Bytes{1}), "100000 100000 100000"));
  write_text(folder / "short.nrrd", nrrd("uchar", "only this"));
  write_text(folder / "flat.nrrd", nrrd("uchar", voxels(Bytes{1}), "4 4 4", "1 0 1"));
  write_text(folder / "far.nrrd",
             nrrd("uchar", voxels(Bytes{1}), "4 4 4", "1 1 1\naxis mins: 1e7 0 0"));
  write_text(folder / "noise.nii.gz", "this is not a compressed volume");
  write_text(folder / "text.txt", "hello");
  std::filesystem::create_directory(folder / "folder");
  write_text(folder / "tetra.obj",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  write_text(folder / "open.obj",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  write_text(folder / "range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  write_text(folder / "old.vtp", "an old surface");
}

TEST(Help, ProgramListsItsSubcommands) {
  const Outcome help = vasamesh_with({"--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_EQ(help.err, "");
  for (const char* part : {"convert", "check", "phantom", "devices", "Examples:"})
    EXPECT_THAT(help.out, HasSubstr(part));
}

TEST(Help, EachSubcommandHasExamplesAndItsOptions) {
  const std::vector<std::pair<std::string, std::vector<const char*>>> options = {
      {"convert",
       {"--output",        "--report",   "--backend",   "--device",        "--threads",
        "--neighbours",    "--normals",  "--depth",     "--kernel-width",  "--connectivity",
        "--close-handles", "--label",    "--threshold", "--min-component", "--space",
        "--surface",       "--preset",   "--rho",       "--edges-around",  "--chord-error",
        "--triangles",     "--edge-min", "--edge-max",  "--gradation",     "--stitch",
        "--max-memory",    "--quiet"}},
      {"check", {"--against", "--reference", "--json"}},
      {"phantom", {"--surface", "--seed", "sphere", "cerebral"}},
      {"devices", {}}};
  for (const auto& [name, parts] : options) {
    const Outcome help = vasamesh_with({name, "--help"});
    EXPECT_EQ(help.code, 0) << name;
    EXPECT_THAT(help.out, HasSubstr("Examples:"));
    EXPECT_THAT(help.out, HasSubstr("vasamesh " + name));
    for (const char* part : parts) EXPECT_THAT(help.out, HasSubstr(part));
  }
}

TEST(Help, Version) {
  const Outcome version = vasamesh_with({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.out, "vasamesh " VASAMESH_VERSION "\n");
}

TEST(Devices, TheCpuIsNumberZero) {
  const Outcome devices = vasamesh_with({"devices"});
  EXPECT_EQ(devices.code, 0);
  EXPECT_EQ(devices.err, "");
  EXPECT_THAT(devices.out, HasSubstr("\n 0  tbb"));
}

struct Fault {
  std::string name;
  Arguments arguments;  ///< @ stands for the folder of the inputs
  int code;
  std::vector<std::string> parts;  ///< of the message
};

void PrintTo(const Fault& fault, std::ostream* stream) { *stream << fault.name; }

class Faults : public testing::TestWithParam<Fault> {
 protected:
  Faults() { make_inputs(folder_); }

  Outcome run() const {
    Arguments arguments = GetParam().arguments;
    for (std::string& argument : arguments)
      if (argument.starts_with('@')) argument = folder_ / argument.substr(1);
    return vasamesh_with(arguments);
  }

  Scratch folder_;
};

TEST_P(Faults, OneLineAndItsCode) {
  const std::vector<std::string> before = folder_.names();
  const Outcome outcome = run();
  EXPECT_EQ(outcome.code, GetParam().code) << outcome.err;
  EXPECT_THAT(outcome.err, StartsWith("vasamesh: "));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_THAT(outcome.err, EndsWith("\n"));
  for (const std::string& part : GetParam().parts) EXPECT_THAT(outcome.err, HasSubstr(part));
  EXPECT_EQ(outcome.out.empty(), GetParam().code != 4);
  EXPECT_EQ(folder_.names(), before);
  EXPECT_EQ(read_text(folder_ / "old.vtp"), "an old surface");
}

/// `convert` of a good input with further arguments.
Arguments convert(const std::string& input, Arguments further = {}) {
  Arguments arguments = {"convert", input, "-o", "@old.vtp"};
  arguments.insert(arguments.end(), further.begin(), further.end());
  return arguments;
}

const Fault kWrongUse[] = {
    {"nothing", {}, 2, {"subcommand", "vasamesh --help"}},
    {"unknown_subcommand", {"polish"}, 2, {"polish"}},
    {"unknown_option", convert("@good.nrrd", {"--gloss"}), 2, {"--gloss", "convert --help"}},
    {"no_input", {"convert", "-o", "@old.vtp"}, 2, {"IN is required"}},
    {"no_output", {"convert", "@good.nrrd"}, 2, {"--output is required"}},
    {"unknown_ending", {"convert", "@good.nrrd", "-o", "@new.xyz"}, 2, {"new.xyz", ".vtp"}},
    {"neighbours", convert("@good.nrrd", {"--neighbours", "2"}), 2, {"--neighbours", "3 to 64"}},
    {"depth", convert("@good.nrrd", {"--depth", "99"}), 2, {"--depth", "24"}},
    {"kernel_width", convert("@good.nrrd", {"--kernel-width", "9"}), 2, {"--kernel-width", "0.5"}},
    {"connectivity", convert("@good.nrrd", {"--connectivity", "7"}), 2, {"--connectivity", "18"}},
    {"normals", convert("@good.nrrd", {"--normals", "up"}), 2, {"--normals", "gradient"}},
    {"surface", convert("@good.nrrd", {"--surface", "smooth"}), 2, {"--surface", "adaptive"}},
    {"preset", convert("@good.nrrd", {"--preset", "best"}), 2, {"--preset", "simulator"}},
    {"stitch", convert("@good.nrrd", {"--stitch", "loose"}), 2, {"--stitch", "exact"}},
    {"rho", convert("@good.nrrd", {"--rho", "0"}), 2, {"--rho", "0.001 to 2"}},
    {"chord_error", convert("@good.nrrd", {"--chord-error", "3"}), 2, {"--chord-error", "1 voxel"}},
    {"edges_around", convert("@good.nrrd", {"--edges-around", "3"}), 2, {"--edges-around", "4 to"}},
    {"gradation", convert("@good.nrrd", {"--gradation", "9"}), 2, {"--gradation", "0.01 to 2"}},
    {"edge_min_above_edge_max",
     convert("@good.nrrd", {"--edge-min", "3", "--edge-max", "2"}),
     2,
     {"--edge-min 3 is above --edge-max 2", "lower the one or raise the other"}},
    {"edge_min_above_the_default",
     convert("@good.nrrd", {"--edge-min", "2"}),
     2,
     {"--edge-min 2 is above --edge-max 1.6 (the default)"}},
    {"edges_around_and_triangles",
     convert("@good.nrrd", {"--edges-around", "9", "--triangles", "5000"}),
     2,
     {"--edges-around", "--triangles"}},
    {"too_many_triangles",
     convert("@good.nrrd", {"--surface", "adaptive", "--triangles", "100000000"}),
     2,
     {"100000000 triangles", "ask for about"}},
    {"triangles_of_the_base_surface",
     convert("@good.nrrd", {"--triangles", "5000", "--surface", "base"}),
     2,
     {"--triangles", "base surface", "no edge lengths to choose"}},
    {"stitch_of_the_base_surface",
     convert("@good.nrrd", {"--surface", "base", "--stitch", "exact"}),
     2,
     {"--stitch", "base surface"}},
    {"space", convert("@good.nrrd", {"--space", "outer"}), 2, {"--space", "ras"}},
    {"label", convert("@good.nrrd", {"--label", "liver"}), 2, {"--label", "any"}},
    {"label_beyond_64_bits",
     convert("@good.nrrd", {"--label", "18446744073709551615"}),
     2,
     {"--label", "up to 9223372036854775807"}},
    {"two_selections", convert("@good.nrrd", {"--label", "1", "--threshold", "1"}), 2, {"--label"}},
    {"min_component", convert("@good.nrrd", {"--min-component", "-5"}), 2, {"--min-component"}},
    {"max_memory",
     convert("@good.nrrd", {"--max-memory", "lots"}),
     2,
     {"--max-memory: give bytes, as 500M or 2G; see"}},
    {"max_memory_beyond_64_bits",
     convert("@good.nrrd", {"--max-memory", "99999999999999999999"}),
     2,
     {"--max-memory"}},
    {"max_memory_beyond_63_bits",
     convert("@good.nrrd", {"--max-memory", "9999999999G"}),
     2,
     {"--max-memory"}},
    {"threads", convert("@good.nrrd", {"--threads", "-1"}), 2, {"--threads"}},
    {"backend", convert("@good.nrrd", {"--backend", "abacus"}), 2, {"--backend", "opencl"}},
    {"report_is_output", convert("@good.nrrd", {"--report", "@old.vtp"}), 2, {"--report"}},
    {"check_label_alone", {"check", "@tetra.obj", "--label", "3"}, 2, {"--label", "--against"}},
    {"check_threshold_alone",
     {"check", "@tetra.obj", "--threshold", "3"},
     2,
     {"--threshold", "--against"}},
    {"check_connectivity_alone",
     {"check", "@tetra.obj", "--connectivity", "6"},
     2,
     {"--connectivity", "--against"}},
    {"phantom_name", {"phantom", "unicorn", "-o", "@x.nii"}, 2, {"unicorn", "torus"}},
    {"phantom_ending", {"phantom", "sphere", "-o", "@x.txt"}, 2, {"x.txt", ".nii.gz"}},
    {"phantom_no_exact",
     {"phantom", "single_voxel", "-o", "@x.nii", "--surface", "@x.ply"},
     2,
     {"--surface", "single_voxel"}},
};

const Fault kNoDevice[] = {
    {"device", convert("@good.nrrd", {"--device", "nosuch"}), 5, {"nosuch"}},
    {"opencl_device",
     convert("@good.nrrd", {"--backend", "opencl", "--device", "nosuch"}),
     5,
     {"nosuch"}},
};

const std::string kLong(252, 'l');  // too long with its ending, as the temporary's is not

const Fault kRefused[] = {
    {"no_folder", {"convert", "@good.nrrd", "-o", "@nowhere/x.vtp"}, 6, {"nowhere"}},
    {"no_report_folder", convert("@good.nrrd", {"--report", "@nowhere/x.json"}), 6, {"nowhere"}},
    {"long_name", {"convert", "@good.nrrd", "-o", "@" + kLong + ".ply"}, 6, {"a shorter name"}},
    {"long_report_name",
     convert("@good.nrrd", {"--report", "@" + kLong + ".json"}),
     6,
     {kLong, "a shorter name"}},
    {"long_map_name",
     {"check", "@tetra.obj", "--map", "@" + kLong + ".vtp"},
     6,
     {kLong, "a shorter name"}},
    {"phantom_no_folder", {"phantom", "sphere", "-o", "@nowhere/x.nii"}, 6, {"nowhere"}},
    {"memory", convert("@good.nrrd", {"--max-memory", "1K"}), 6, {"memory"}},
};

const Fault kBadInput[] = {
    {"missing", convert("@missing.nii.gz"), 3, {"missing.nii.gz"}},
    {"folder", convert("@folder"), 3, {"folder", "DICOM"}},
    {"unknown_format", convert("@text.txt"), 3, {"text.txt"}},
    {"noise", convert("@noise.nii.gz"), 3, {"noise.nii.gz"}},
    {"empty", convert("@empty.nrrd"), 3, {"empty.nrrd", "nothing in the foreground"}},
    {"several_labels", convert("@labels.nrrd"), 3, {"labels.nrrd", "3", "7", "--label"}},
    {"absent_label", convert("@labels.nrrd", {"--label", "5"}), 3, {"labels.nrrd", "5", "3", "7"}},
    {"grey", convert("@grey.nrrd"), 3, {"grey.nrrd", "--threshold"}},
    {"threshold", convert("@grey.nrrd", {"--threshold", "100"}), 3, {"grey.nrrd", "threshold"}},
    {"nan", convert("@nan.nrrd"), 3, {"nan.nrrd", "NaN"}},
    {"huge", convert("@huge.nrrd"), 3, {"huge.nrrd"}},
    {"too_short", convert("@short.nrrd"), 3, {"short.nrrd"}},
    {"zero_spacing", convert("@flat.nrrd"), 3, {"flat.nrrd", "spacing"}},
    {"far_origin",
     convert("@far.nrrd"),
     3,
     {"far.nrrd: the volume", "about 10000007 mm", "--space voxel", "its origin"}},
    {"min_component_above_all",
     convert("@good.nrrd", {"--min-component", "1000"}),
     3,
     {"good.nrrd: ", "fewer voxels than --min-component, 1000"}},
    {"check_missing", {"check", "@missing.stl"}, 3, {"missing.stl"}},
    {"check_indices", {"check", "@range.obj"}, 3, {"range.obj"}},
    {"check_volume", {"check", "@tetra.obj", "--against", "@empty.nrrd"}, 3, {"empty.nrrd"}},
    {"check_reference", {"check", "@tetra.obj", "--reference", "@no.ply"}, 3, {"no.ply"}},
};

const Fault kFailedCheck[] = {
    {"hole", {"check", "@open.obj"}, 4, {"open.obj", "open"}},
    {"hole_json", {"check", "@open.obj", "--json"}, 4, {"open.obj", "open"}},
};

std::string fault_name(const testing::TestParamInfo<Fault>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(WrongUse, Faults, testing::ValuesIn(kWrongUse), fault_name);
INSTANTIATE_TEST_SUITE_P(NoDevice, Faults, testing::ValuesIn(kNoDevice), fault_name);
INSTANTIATE_TEST_SUITE_P(Refused, Faults, testing::ValuesIn(kRefused), fault_name);
INSTANTIATE_TEST_SUITE_P(BadInput, Faults, testing::ValuesIn(kBadInput), fault_name);
INSTANTIATE_TEST_SUITE_P(FailedCheck, Faults, testing::ValuesIn(kFailedCheck), fault_name);

TEST(Output, AFullDiskUnderStandardOutputIsRefused) {
  for (const Arguments& arguments :
       {Arguments{"devices"}, {"--help"}, {"convert", "--help"}, {"--version"}}) {
    const Outcome outcome = vasamesh_with(arguments, "/dev/full");
    EXPECT_EQ(outcome.code, 6) << arguments.front();
    EXPECT_THAT(outcome.err, HasSubstr("standard output"));
  }
}

/// More than stdout holds back, so that the printing itself fails.
TEST(Output, AFullDiskUnderMuchOutputIsRefused) {
  const Scratch folder;
  write_text(folder / "good.nrrd", nrrd("uchar", voxels(std::vector<unsigned char>{1, 1})));
  const std::string input = folder / "good.nrrd";
  const Outcome outcome = vasamesh_with(
      {"bench", input, input, "--json", "--repeat", "1", "--backends", "tbb", "--threads", "1"},
      "/dev/full");
  EXPECT_EQ(outcome.code, 6);
  EXPECT_THAT(outcome.err, HasSubstr("standard output"));
}

/// \return the exit code with what the shell makes of the streams.
int code_with(const std::string& redirection, const Arguments& arguments) {
  Arguments all = {"/bin/sh", "-c", "exec \"$@\" " + redirection, "sh", VASAMESH_PROGRAM};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return run_program(all).code;
}

TEST(Output, StreamsMayBeClosedOrFull) {
  const Scratch folder;
  make_inputs(folder);
  const Arguments loud = {"convert", folder / "good.nrrd", "-o", folder / "new.vtp"};
  Arguments quiet = loud;
  quiet.push_back("--quiet");
  ASSERT_EQ(code_with("", quiet), 0);
  const std::string surface = read_text(folder / "new.vtp");
  for (const char* streams : {"<&- >&- 2>&-", ">&- 2>/dev/full", ">/dev/full 2>&-"}) {
    SCOPED_TRACE(streams);
    EXPECT_EQ(code_with(streams, loud), 6);
    EXPECT_TRUE(read_text(folder / "new.vtp") == surface);
    EXPECT_EQ(code_with(streams, quiet), 0);
    EXPECT_EQ(code_with(streams, {"convert", folder / "empty.nrrd", "-o", folder / "a.vtp"}), 3);
    EXPECT_EQ(code_with(streams, {"--gloss"}), 2);
  }
}

}  // namespace
}  // namespace vasamesh
