/// \file
/// Includes go one way: cli -> host -> pipeline -> stages -> backend -> types. The engine includes
/// no runtime, no file library and no file or console I/O. kernels/ is reached by host/opencl
/// alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = VASAMESH_SOURCE_DIR;

struct Include {
  std::string target;
  bool quoted;
};

bool starts_with_any(const std::string& text, const std::vector<std::string>& prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(),
                     [&](const std::string& prefix) { return text.starts_with(prefix); });
}

/// The folder's place in the order of includes; a file may include its own layer and those below.
/// The scheduler, with the Context that it serves, lies between backend and stages. None for tests
/// and benchmarks, which may see all.
std::optional<int> layer(const std::string& path) {
  struct Place {
    std::string prefix;
    int layer;
  };
  static const std::array<Place, 12> places = {{{"engine/include/vasamesh/pipeline.h", 3},
                                                {"engine/include/", 0},
                                                {"engine/backend/buffer.h", 0},
                                                {"engine/types/", 1},
                                                {"engine/backend/", 2},
                                                {"engine/byte_plan.", 3},
                                                {"engine/scheduler.", 3},
                                                {"engine/stages/", 4},
                                                {"engine/", 5},
                                                {"host/cli/", 7},
                                                {"host/", 6},
                                                {"kernels/", 6}}};
  for (const Place& place : places)
    if (path.starts_with(place.prefix)) return place.layer;
  return std::nullopt;
}

/// The project's file that a quoted include means, relative to the root; none for a generated one.
std::optional<std::string> resolve(const std::string& file, const std::string& target) {
  const std::array<fs::path, 5> folders = {fs::path(file).parent_path(), "engine", "host",
                                           "engine/include", "host/include"};
  for (const fs::path& folder : folders) {
    const fs::path path = (folder / target).lexically_normal();
    if (fs::is_regular_file(kRoot / path)) return path.generic_string();
  }
  return std::nullopt;
}

/// What is wrong with an include of the engine's or the host's libraries; empty when nothing is.
std::string check_library(const std::string& file, const std::string& target) {
  struct Rule {
    std::vector<std::string> headers;
    std::vector<std::string> folders;  ///< that may include them
  };
  static const std::array<Rule, 5> rules = {{
      {{"tbb/", "oneapi/"}, {"host/"}},
      {{"CL/"}, {"host/opencl/"}},
      {{"itk", "gdcm"}, {"host/io/"}},
      {{"vtk"}, {"host/io/", "host/phantom/", "host/picture/", "host/vtk_mesh."}},
      {{"fstream", "iostream", "cstdio", "stdio.h", "filesystem"}, {"host/"}},
  }};
  for (const Rule& rule : rules)
    if (starts_with_any(target, rule.headers) && !starts_with_any(file, rule.folders))
      return file + " includes <" + target + ">, which its folder may not";
  return {};
}

/// A backend stands alone: of the host it includes only its own folder and the public headers.
bool crosses_backends(const std::string& file, const std::string& target) {
  for (const std::string backend : {"host/tbb/", "host/opencl/"})
    if (file.starts_with(backend) && target.starts_with("host/"))
      return !target.starts_with(backend) && !target.starts_with("host/include/");
  return false;
}

/// What is wrong with one include of one file; empty when nothing is.
std::string check_include(const std::string& file, const Include& include) {
  const std::optional<int> own = layer(file);
  if (!own) return {};
  if ((include.target.find("kernels/") != std::string::npos || include.target.ends_with(".cl")) &&
      !starts_with_any(file, {"host/opencl/", "kernels/"}))
    return file + " reaches for a kernel: " + include.target;
  const auto target = include.quoted ? resolve(file, include.target) : std::nullopt;
  if (!target) return check_library(file, include.target);
  const std::optional<int> other = layer(*target);
  if (!other) return file + " includes " + *target + ", which is no part of the library";
  if (*other > *own) return file + " includes " + *target + ", which lies above it";
  if (crosses_backends(file, *target)) return file + " includes another part of the host";
  return {};
}

std::vector<Include> includes_of(const std::string& text) {
  static const std::regex pattern(R"re((?:^|\n)[ \t]*#[ \t]*include[ \t]*(["<])([^">]+)[">])re");
  std::vector<Include> includes;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match)
    includes.push_back({(*match)[2].str(), (*match)[1].str() == "\""});
  return includes;
}

std::vector<std::string> check_source(const std::string& file, const std::string& text) {
  std::vector<std::string> faults;
  for (const Include& include : includes_of(text))
    if (std::string fault = check_include(file, include); !fault.empty())
      faults.push_back(std::move(fault));
  return faults;
}

std::string read(const fs::path& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The files below the engine, the host and the kernels whose names end so.
std::vector<std::string> files(const std::vector<std::string>& endings) {
  std::vector<std::string> found;
  for (const char* folder : {"engine", "host", "kernels"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string path = fs::relative(entry.path(), kRoot).generic_string();
      if (std::any_of(endings.begin(), endings.end(),
                      [&](const std::string& ending) { return path.ends_with(ending); }))
        found.push_back(path);
    }
  return found;
}

TEST(Layout, IncludesGoOneWay) {
  const std::vector<std::string> sources = files({".h", ".cpp", ".cl"});
  ASSERT_GT(sources.size(), 30u);
  for (const std::string& file : sources)
    for (const std::string& fault : check_source(file, read(kRoot / file))) ADD_FAILURE() << fault;
}

/// Types of one name in two headers would share their inline destructors: the linker keeps one.
TEST(Layout, NoTwoHeadersDefineATypeOfOneName) {
  static const std::regex pattern(
      R"re(\n(?:enum )?(?:struct|class) ([A-Z]\w*)(?: final)?(?: :[^;{]*)? \{)re");
  std::map<std::string, std::string> homes;
  for (const std::string& file : files({".h"})) {
    const std::string text = read(kRoot / file);
    for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end;
         ++match) {
      const auto [home, is_new] = homes.emplace((*match)[1].str(), file);
      EXPECT_TRUE(is_new) << home->first << " is defined in " << home->second << " and " << file;
    }
  }
  EXPECT_GT(homes.size(), 50u);
}

TEST(Layout, OnlyTheOpenClBackendBuildsKernels) {
  for (const std::string& file : files({"CMakeLists.txt"})) {
    if (file.starts_with("host/opencl/")) continue;
    EXPECT_EQ(read(kRoot / file).find("kernels/"), std::string::npos) << file;
  }
}

// The negative controls: each of these must be caught.
TEST(Layout, CatchesEachWrongDirection) {
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"engine/types/volume.h", "#include \"backend/backend.h\"\n"},
      {"engine/backend/backend.h", "#include \"stages/points.h\"\n"},
      {"engine/backend/backend.h", "#include \"scheduler.h\"\n"},
      {"engine/types/volume.h", "#include \"vasamesh/pipeline.h\"\n"},
      {"engine/scheduler.h", "#include \"stages/points.h\"\n"},
      {"engine/parameters.cpp", "#include \"vasamesh/host.h\"\n"},
      {"engine/stages/points.cpp", "int a;\n  # include <tbb/parallel_for.h>\n"},
      {"engine/stages/points.cpp", "#include <CL/cl.h>\n"},
      {"engine/stages/points.cpp", "#include <vtkPolyData.h>\n"},
      {"engine/stages/points.cpp", "#include <fstream>\n"},
      {"engine/stages/points.cpp", "#include \"../../kernels/poisson.cl\"\n"},
      {"engine/stages/points.cpp", "#include \"../../tests/layout_test.cpp\"\n"},
      {"host/tbb/backend.cpp", "#include \"opencl/backend.h\"\n"},
      {"host/tbb/backend.cpp", "#include <itkImage.h>\n"},
      {"host/io/reader.cpp", "#include <CL/cl.h>\n"},
      {"host/io/reader.cpp", "#include \"cli/commands.h\"\n"}};
  for (const auto& [file, text] : wrong)
    EXPECT_EQ(check_source(file, text).size(), 1u) << file << ": " << text;
}

TEST(Layout, LetsTheRightDirectionPass) {
  EXPECT_TRUE(check_source("host/cli/main.cpp", "#include \"vasamesh/pipeline.h\"\n").empty());
  EXPECT_TRUE(check_source("host/tbb/points.cpp", "#include \"stages/points.h\"\n").empty());
  EXPECT_TRUE(check_source("engine/stages/points.h", "#include \"backend/backend.h\"\n").empty());
}

}  // namespace
