/// Kernel files, their builds, and the cache of built programs on disk.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "opencl/arithmetic.h"
#include "opencl/backend.h"
#include "opencl/opencl_backend.h"
#include "opencl/program.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

namespace fs = std::filesystem;

class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::string& name)
      : path_(fs::temp_directory_path() / ("vasamesh_" + name + std::to_string(getpid()))) {
    fs::remove_all(path_);
  }
  ~TemporaryFolder() { fs::remove_all(path_); }
  const fs::path& path() const { return path_; }
  std::size_t files() const {
    if (!fs::exists(path_)) return 0;
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), {}));
  }

 private:
  fs::path path_;
};

/// The names of the kernels in a file's text: what stands between "void " and "(" of each.
std::set<std::string> kernels_in(const std::string& text) {
  std::set<std::string> names;
  for (std::size_t at = text.find("\nkernel "); at != std::string::npos;
       at = text.find("\nkernel ", at + 1)) {
    const std::size_t name = text.find("void ", at) + 5;
    names.insert(text.substr(name, text.find('(', name) - name));
  }
  return names;
}

constexpr KernelSource kSmall[] = {
    {"common.cl", "#define ONE 1.0f\n"},
    {"small.cl",
     "kernel void small_run(global float *v) { v[0] = ONE; }\n"
     "kernel void small_walk(global float *v) { v[get_global_id(0)] = ONE; }\n"}};

class OpenClPrograms : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::vector<cl::Device> devices = opencl_devices();
    if (devices.empty()) GTEST_SKIP() << "no OpenCL device here";
    device_ = devices[0];
    context_ = cl::Context(device_);
  }
  Programs programs(const fs::path& cache, std::span<const KernelSource> sources = kSmall) {
    return Programs(context_, device_, kOneItemShape, ProgramCache(cache), sources);
  }

  cl::Device device_;
  cl::Context context_;
};

TEST_F(OpenClPrograms, EveryKernelOfEveryFileBuilds) {
  const std::set<std::string> without_kernels = {"common", "expand_front", "expand_propose"};
  for (const WorkShape& shape : {kOneItemShape, kWorkGroupShape}) {
    Programs built(context_, device_, shape, std::nullopt);
    std::set<std::string> seen;
    for (const KernelSource& source : kernel_sources()) {
      const std::string stage(source.file.substr(0, source.file.find('.')));
      const std::set<std::string> names = kernels_in(std::string(source.text));
      EXPECT_EQ(names.empty(), without_kernels.contains(stage)) << source.file;
      for (const std::string& name : names) {
        EXPECT_TRUE(seen.insert(name).second) << name << " twice, in " << source.file;
        EXPECT_EQ(built.kernel(name).getInfo<CL_KERNEL_FUNCTION_NAME>(), name);
      }
    }
  }
}

TEST_F(OpenClPrograms, FailedBuildNamesFileDeviceAndLine) {
  const TemporaryFolder folder("failed_build");
  const KernelSource sources[] = {{"common.cl", "#define ZERO 0\n"},
                                  {"broken.cl", "\nkernel void broken_run() { no_such(ZERO) }\n"}};
  Programs built = programs(folder.path(), sources);
  try {
    built.kernel("broken_run");
    FAIL() << "the file does not build";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.code(), ErrorCode::internal);
    EXPECT_NE(message.find("broken.cl:2"), std::string::npos) << message;
    EXPECT_NE(message.find(device_.getInfo<CL_DEVICE_NAME>()), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_EQ(folder.files(), 0u);
}

TEST_F(OpenClPrograms, UnknownKernels) {
  const TemporaryFolder folder("unknown");
  Programs built = programs(folder.path());
  EXPECT_THROW(built.kernel("small_nothing"), Error);
  EXPECT_THROW(built.kernel("nothing_at_all"), Error);
}

TEST_F(OpenClPrograms, ProgramIsKeptAndTakenFromTheCache) {
  const TemporaryFolder folder("kept");
  programs(folder.path()).kernel("small_run");
  ASSERT_EQ(folder.files(), 1u);
  const fs::path file = fs::directory_iterator(folder.path())->path();
  const auto written = fs::last_write_time(file) - std::chrono::hours(1);
  fs::last_write_time(file, written);
  programs(folder.path()).kernel("small_walk");
  EXPECT_EQ(folder.files(), 1u);
  EXPECT_EQ(fs::last_write_time(file), written) << "built again, though it was there";
}

TEST_F(OpenClPrograms, DamagedFileIsBuiltAgain) {
  const TemporaryFolder folder("damaged");
  programs(folder.path()).kernel("small_run");
  const fs::path file = fs::directory_iterator(folder.path())->path();
  const auto size = fs::file_size(file);
  {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(static_cast<std::streamoff>(size) - 100);
    stream.put('?').put('!');
  }
  EXPECT_NO_THROW(programs(folder.path()).kernel("small_run"));
  fs::resize_file(file, size / 2);
  EXPECT_NO_THROW(programs(folder.path()).kernel("small_run"));
  EXPECT_EQ(fs::file_size(file), size) << "not written again";
}

TEST_F(OpenClPrograms, FolderThatCannotBeMadeCostsNoError) {
  const TemporaryFolder folder("no_folder");
  std::ofstream(folder.path()) << "a file where the folder should be";
  EXPECT_NO_THROW(programs(folder.path() / "cache").kernel("small_run"));
}

/// Devices that compute otherwise: the sum, quotient or root of theirs, and what is said of it.
TEST_F(OpenClPrograms, ProbeTellsWhatIsOtherwise) {
  struct Liberty {
    std::string sum, quotient, root, words;
  };
  const Liberty as_specified{"a * b + c", "a / b", "sqrt(a)", ""};
  std::vector<Liberty> liberties(5, as_specified);
  liberties[1].sum = "fma(a, b, c)";
  liberties[1].words = "contracts products";
  liberties[2].sum = "fabs(a * b + c) < 0x1p-126f ? 0.0f : a * b + c";
  liberties[2].words = "drops sub-normal numbers";
  liberties[3].quotient = "a * (1.0f / b)";
  liberties[3].words = "rounds quotients otherwise than IEEE 754";
  liberties[4].sum = "fma(a, b, c)";
  liberties[4].root = "1.0f / (1.0f / sqrt(a))";
  liberties[4].words = "contracts products, rounds square roots otherwise than IEEE 754";
  const TemporaryFolder folder("probe");
  const cl::CommandQueue queue(context_, device_);
  for (const Liberty& liberty : liberties) {
    const std::string probe =
        "#pragma OPENCL FP_CONTRACT OFF\n"
        "kernel void primitives_probe(global const float *factors, global float *values) {\n"
        "  const size_t i = get_global_id(0);\n"
        "  const float a = factors[3 * i], b = factors[3 * i + 1], c = factors[3 * i + 2];\n"
        "  values[3 * i] = " +
        liberty.sum +
        ";\n"
        "  values[3 * i + 1] = " +
        liberty.quotient +
        ";\n"
        "  values[3 * i + 2] = " +
        liberty.root +
        ";\n"
        "}\n";
    const KernelSource sources[] = {{"common.cl", ""}, {"primitives.cl", probe}};
    Programs built = programs(folder.path(), sources);
    EXPECT_EQ(other_arithmetic(context_, queue, built), liberty.words) << probe;
  }
  Programs ours(context_, device_, kOneItemShape, std::nullopt);
  EXPECT_EQ(other_arithmetic(context_, queue, ours), "");
}

TEST(ProgramCache, GivesBackWhatWasStored) {
  const TemporaryFolder folder("stored");
  const ProgramCache cache(folder.path());
  const std::string binary("\0one\ntwo\xff", 9);
  EXPECT_FALSE(cache.load("key"));
  cache.store("key", binary);
  EXPECT_EQ(cache.load("key"), binary);
  EXPECT_FALSE(cache.load("another key"));
  cache.store("key", "");
  EXPECT_EQ(cache.load("key"), "");
}

TEST(ProgramCache, AnotherKeysFileCountsAsAbsent) {
  const TemporaryFolder folder("another");
  const ProgramCache cache(folder.path());
  cache.store("one", "binary of one");
  fs::rename(cache.path("one"), cache.path("two"));
  EXPECT_FALSE(cache.load("two"));
}

TEST(ProgramCache, AnyByteLostOrChangedCountsAsAbsent) {
  const TemporaryFolder folder("any_byte");
  const ProgramCache cache(folder.path());
  cache.store("key", "a binary");
  std::ifstream in(cache.path("key"), std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    std::ofstream(cache.path("key"), std::ios::binary) << changed;
    EXPECT_FALSE(cache.load("key")) << "byte " << i << " changed";
    std::ofstream(cache.path("key"), std::ios::binary) << whole.substr(0, i);
    EXPECT_FALSE(cache.load("key")) << "cut at " << i;
  }
}

TEST(ProgramCache, ManyWritersLeaveOneWholeFile) {
  const TemporaryFolder folder("writers");
  std::vector<std::thread> writers;
  for (int i = 0; i < 4; ++i)
    writers.emplace_back([&, i] {
      const ProgramCache cache(folder.path());
      for (int k = 0; k < 50; ++k) {
        cache.store("key", std::string(10000, static_cast<char>('a' + i)));
        const auto got = cache.load("key");
        ASSERT_TRUE(got && got->size() == 10000 && *got == std::string(10000, got->front()));
      }
    });
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(folder.files(), 1u);
}

}  // namespace
}  // namespace vasamesh
