/// Drivers that fail: whatever call fails, a conversion ends with the same surface, finished by
/// oneTBB and saying so, or the device is refused before the work by one clear error.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "backend/backend.h"
#include "opencl/backend.h"
#include "opencl/opencl_backend.h"
#include "opencl/tuning.h"
#include "phantom/phantom.h"
#include "support/environment.h"
#include "support/failing_opencl.h"
#include "support/scratch.h"
#include "tbb/backend.h"
#include "tune.h"
#include "vasamesh/host.h"
#include "vasamesh/pipeline.h"

namespace vasamesh {
namespace {

namespace failing = failing_opencl;

const Phantom& volume() {
  static const Phantom phantom = [] {
    PhantomOptions options;
    options.radius = 2.0;
    return make_phantom("sphere", options);
  }();
  return phantom;
}

Context context_on(const std::string& backend) {
  ContextOptions options;
  options.backend = backend;
  options.threads = 2;
  return make_context(options);
}

Result convert_on(const std::string& backend) {
  Context context = context_on(backend);
  return convert(volume().view(), {}, context);
}

const TriangleMesh& wanted() {
  static const TriangleMesh mesh = convert_on("tbb").mesh;
  return mesh;
}

/// Whether a device failed; then the stages before and with the failing one are followed by a whole
/// run on oneTBB.
bool fell_back(const Report& report) {
  std::vector<std::string> names;
  bool failed = false;
  for (const StageReport& stage : report.stages) {
    if (failed) {
      EXPECT_EQ(stage.backend, "tbb") << stage.name;
      names.push_back(stage.name);
    }
    if (stage.failure.empty()) continue;
    EXPECT_FALSE(failed) << "tried again after it had failed";
    failed = true;
  }
  if (failed) {
    EXPECT_EQ(names.front(), "input");
    EXPECT_EQ(names.back(), "quality");
  }
  return failed;
}

/// What became of a conversion in which something failed.
enum class Ending { unharmed, finished_on_tbb, refused };

/// \param again  once more on the same device, when it works again.
Ending convert_failing(const std::function<void()>& make_fail, bool again = false) {
  wanted();
  make_fail();
  Ending ending = Ending::refused;
  try {
    Context context = context_on("opencl");
    const Result result = convert(volume().view(), {}, context);
    EXPECT_TRUE(result.mesh.vertices == wanted().vertices);
    EXPECT_TRUE(result.mesh.triangles == wanted().triangles);
    ending = fell_back(result.report) ? Ending::finished_on_tbb : Ending::unharmed;
    failing::reset();
    if (again) {
      const Result later = convert(volume().view(), {}, context);
      EXPECT_FALSE(fell_back(later.report));
      EXPECT_TRUE(later.mesh.vertices == wanted().vertices);
      EXPECT_TRUE(later.mesh.triangles == wanted().triangles);
    }
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::no_device) << error.what();
    EXPECT_NE(std::string(error.what()).find("tbb"), std::string::npos) << error.what();
  }
  failing::reset();
  return ending;
}

/// Work-groups and memory of its own, as a GPU has.
void pretend_gpu() {
  failing::pretend(CL_DEVICE_TYPE, CL_DEVICE_TYPE_GPU);
  failing::pretend(CL_DEVICE_HOST_UNIFIED_MEMORY, CL_FALSE);
}

/// In the host's memory.
void pretend_integrated_gpu() {
  failing::pretend(CL_DEVICE_TYPE, CL_DEVICE_TYPE_GPU);
  failing::pretend(CL_DEVICE_HOST_UNIFIED_MEMORY, CL_TRUE);
}

/// The calls of a conversion in which nothing fails, its programs in the cache.
std::vector<failing::Call> calls_of_a_conversion(const std::function<void()>& pretend = [] {}) {
  for (int run = 0; run < 2; ++run) {
    failing::reset();
    pretend();
    convert_on("opencl");
  }
  return failing::calls();
}

/// What is only asked, kept or given back may fail unseen, as may a program from the cache.
bool harmless(const std::string& function) {
  return function.starts_with("clRelease") || function.starts_with("clRetain") ||
         function.starts_with("clGet") || function == "clFinish" ||
         function == "clEnqueueUnmapMemObject" || function == "clCreateProgramWithBinary" ||
         function == "clBuildProgram";
}

class OpenClFailure : public ::testing::Test {
 protected:
  void SetUp() override {
    failing::reset();
    if (list_opencl_devices().empty()) GTEST_SKIP() << "no OpenCL device here";
  }
  void TearDown() override { failing::reset(); }
};

/// \param pretend  what the device is, which a failure makes forgotten.
Ending convert_failing_at(const failing::Call& site, const std::function<void()>& pretend) {
  SCOPED_TRACE(site.function);
  const auto fail = [&] {
    failing::fail_at(site);
    pretend();
  };
  return convert_failing(fail, true);
}

/// \return the sites.
std::set<failing::Call> fail_every_call_site(const std::function<void()>& pretend) {
  const std::vector<failing::Call> calls = calls_of_a_conversion(pretend);
  const std::set<failing::Call> sites(calls.begin(), calls.end());
  std::set<Ending> endings;
  for (const failing::Call& call : sites) {
    const Ending ending = convert_failing_at(call, pretend);
    endings.insert(ending);
    if (!harmless(call.function)) {
      EXPECT_NE(ending, Ending::unharmed) << call.function;
    }
  }
  EXPECT_EQ(endings.size(), 3u);
  return sites;
}

TEST_F(OpenClFailure, EveryCallSite) {
  EXPECT_GT(fail_every_call_site([] {}).size(), 30u);
}

TEST_F(OpenClFailure, EveryCallSiteWithMemoryOfItsOwn) {
  const std::set<failing::Call> sites = fail_every_call_site(pretend_gpu);
  EXPECT_GT(sites.size(), 30u);
  EXPECT_TRUE(std::any_of(sites.begin(), sites.end(), [](const failing::Call& call) {
    return call.function == "clEnqueueMapBuffer";  // of pinned memory
  }));
}

/// Where the host takes memory from the device and gives it back; when it is released, unseen.
TEST_F(OpenClFailure, EveryMapping) {
  std::set<failing::Call> sites;
  for (const failing::Call& call : calls_of_a_conversion(pretend_integrated_gpu))
    if (call.function == "clEnqueueMapBuffer" || call.function == "clEnqueueUnmapMemObject")
      sites.insert(call);
  int seen = 0;
  for (const failing::Call& call : sites) {
    const Ending ending = convert_failing_at(call, pretend_integrated_gpu);
    EXPECT_NE(ending, Ending::refused) << call.function;
    seen += ending == Ending::finished_on_tbb;
  }
  EXPECT_GE(seen, 2);
}

TEST_F(OpenClFailure, TwoHundredCallsSpreadOverAConversion) {
  const std::size_t calls = calls_of_a_conversion().size();
  ASSERT_GT(calls, 200u);
  std::set<Ending> endings;
  for (std::size_t i = 0; i < 200; ++i) {
    const std::size_t first = i * calls / 200;
    const std::size_t count = i % 2 ? failing::kForEver : 1;
    SCOPED_TRACE("call " + std::to_string(first) + (i % 2 ? " and all later ones" : ""));
    endings.insert(convert_failing([&] { failing::fail(first, count); }));
  }
  EXPECT_EQ(endings.count(Ending::finished_on_tbb), 1u);
  EXPECT_EQ(endings.count(Ending::refused), 1u);
}

/// What make_context says when it refuses.
std::string refusal(const ContextOptions& options) {
  try {
    make_context(options);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::no_device) << error.what();
    return error.what();
  }
  return "";
}

ContextOptions on_opencl() {
  ContextOptions options;
  options.backend = "opencl";
  return options;
}

TEST_F(OpenClFailure, NoPlatformIsNoDevice) {
  failing::fail(0, failing::kForEver);
  EXPECT_TRUE(list_opencl_devices().empty());
  EXPECT_EQ(list_devices().size(), 1u);
  EXPECT_NE(refusal(on_opencl()).find("install a driver"), std::string::npos);
  ContextOptions any;
  EXPECT_EQ(refusal(any), "");
}

TEST_F(OpenClFailure, DeviceThatLacksSomethingIsRefusedByName) {
  const std::string name = list_opencl_devices()[0].name;
  const std::pair<cl_device_info, std::string> lacking[] = {
      {CL_DEVICE_LOCAL_MEM_SIZE, "local memory"},
      {CL_DEVICE_MAX_WORK_GROUP_SIZE, "work-groups"},
      {CL_DEVICE_ENDIAN_LITTLE, "big-endian"}};
  for (const auto& [property, word] : lacking) {
    failing::reset();
    failing::pretend(property, 0);
    const std::string message = refusal(on_opencl());
    EXPECT_NE(message.find(word), std::string::npos) << message;
    EXPECT_NE(message.find(name), std::string::npos) << message;
    EXPECT_NE(message.find("--backend tbb"), std::string::npos) << message;
  }
}

TEST_F(OpenClFailure, DeviceThatFailsItsTrialIsTriedOnce) {
  const Scratch folder;
  const Variable cache("XDG_CACHE_HOME", folder / "cache");
  const DeviceInfo device = list_devices()[1];
  const std::shared_ptr<Backend> host = make_tbb_backend(2, nullptr);
  failing::pretend(CL_DEVICE_MAX_WORK_GROUP_SIZE, 0);
  const DeviceWorth worth = worth_of(device, host, nullptr);
  EXPECT_EQ(worth.stages, 0u);
  EXPECT_NE(worth.reason.find(device.name), std::string::npos) << worth.reason;
  EXPECT_NE(worth.reason.find("work-groups"), std::string::npos) << worth.reason;
  failing::reset();
  EXPECT_EQ(worth_of(device, host, nullptr), worth);
  for (const failing::Call& call : failing::calls()) EXPECT_NE(call.function, "clCreateContext");
}

/// As by a driver that takes the program down.
TEST_F(OpenClFailure, DeviceWhoseTrialWasCutShortIsNotTriedAgain) {
  const Scratch folder;
  const Variable cache("XDG_CACHE_HOME", folder / "cache");
  const DeviceInfo device = list_devices()[1];
  const std::shared_ptr<Backend> host = make_tbb_backend(2, nullptr);
  failing::exit_at("clCreateContext");
  EXPECT_EXIT(worth_of(device, host, nullptr), ::testing::ExitedWithCode(failing::kExit), "");
  failing::reset();
  const DeviceWorth worth = worth_of(device, host, nullptr);
  EXPECT_EQ(worth.stages, 0u);
  EXPECT_NE(worth.reason.find("not tried to the end"), std::string::npos) << worth.reason;
  for (const failing::Call& call : failing::calls()) EXPECT_NE(call.function, "clCreateContext");
}

TEST_F(OpenClFailure, DeviceIsNotTriedWhereNothingCanBeRemembered) {
  const Variable cache("XDG_CACHE_HOME", "/proc/none");
  const DeviceInfo device = list_devices()[1];
  failing::reset();
  const DeviceWorth worth = worth_of(device, make_tbb_backend(2, nullptr), nullptr);
  EXPECT_EQ(worth.stages, 0u);
  EXPECT_NE(worth.reason.find("cache folder"), std::string::npos) << worth.reason;
  for (const failing::Call& call : failing::calls()) EXPECT_NE(call.function, "clCreateContext");
}

TEST_F(OpenClFailure, CancelledTrialIsNotRemembered) {
  const Scratch folder;
  const Variable cache("XDG_CACHE_HOME", folder / "cache");
  const DeviceInfo device = list_devices()[1];
  const std::shared_ptr<Backend> host = make_tbb_backend(2, nullptr);
  const std::atomic<bool> cancel = true;
  for (int time = 0; time < 2; ++time) {
    failing::reset();
    try {
      worth_of(device, host, &cancel);
      FAIL() << "cancelled before it began";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled);
    }
    EXPECT_FALSE(failing::calls().empty());
  }
}

/// Shapes that a device cannot run are left out; the others are tried.
TEST_F(OpenClFailure, TuningGoesOnAfterAShapeThatFails) {
  const Scratch folder;
  const Variable cache("XDG_CACHE_HOME", folder / "cache");
  failing::pretend(CL_DEVICE_MAX_WORK_GROUP_SIZE, 32);
  std::vector<TuneTrial> ran, failed;
  const TuneResult result = tune_device(list_devices()[1], 2, [&](const TuneTrial& trial) {
    (trial.failure.empty() ? ran : failed).push_back(trial);
  });
  ASSERT_EQ(ran.size(), 1u);
  EXPECT_EQ(result.best.shape, ran[0].shape);
  ASSERT_GE(failed.size(), 5u);
  EXPECT_EQ(failed[0].shape, "usual");
  EXPECT_NE(failed[0].failure.find("work-groups"), std::string::npos) << failed[0].failure;
  EXPECT_TRUE(result.is_kept);
  ASSERT_TRUE(load_shape(0, {}));
  EXPECT_EQ(load_shape(0, {})->fold_items, 32);
}

TEST_F(OpenClFailure, OpeningIsStoppedOnRequest) {
  const std::atomic<bool> cancel = true;
  ContextOptions options = on_opencl();
  options.cancel = &cancel;
  try {
    make_context(options);
    FAIL() << "opened";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
}

TEST_F(OpenClFailure, DeviceThatIsNotReadyIsNotListed) {
  for (const cl_device_info property : {CL_DEVICE_AVAILABLE, CL_DEVICE_COMPILER_AVAILABLE}) {
    failing::reset();
    failing::pretend(property, 0);
    EXPECT_TRUE(list_opencl_devices().empty());
  }
}

TEST_F(OpenClFailure, DeviceThatIsNoCpuGivesTheSameBytesAndIsCopiedTo) {
  pretend_gpu();
  EXPECT_EQ(list_opencl_devices()[0].type, "gpu");
  const Result result = convert_on("opencl");
  EXPECT_FALSE(fell_back(result.report));
  EXPECT_EQ(result.mesh.vertices, wanted().vertices);
  EXPECT_EQ(result.mesh.triangles, wanted().triangles);
  std::int64_t launches = 0, copies = 0, bytes = 0;
  for (const StageReport& stage : result.report.stages) {
    launches += stage.launches;
    copies += stage.copies;
    bytes += stage.bytes_copied;
  }
  EXPECT_GT(launches, 100);
  EXPECT_GT(copies, 10);
  EXPECT_GT(bytes, 10000);
}

/// Never at once, but for reading: the layer sees to that.
TEST_F(OpenClFailure, IntegratedGpuHasTheHostsMemoryInTurn) {
  pretend_integrated_gpu();
  const Result result = convert_on("opencl");
  EXPECT_FALSE(fell_back(result.report));
  EXPECT_EQ(result.mesh.vertices, wanted().vertices);
  EXPECT_EQ(result.mesh.triangles, wanted().triangles);
  std::int64_t launches = 0;
  for (const StageReport& stage : result.report.stages) {
    launches += stage.launches;
    EXPECT_EQ(stage.copies, 0) << stage.name;
  }
  EXPECT_GT(launches, 100);
  EXPECT_EQ(failing::mapping_faults(), std::vector<std::string>());
  const std::vector<failing::Call> calls = failing::calls();
  EXPECT_GT(std::count_if(calls.begin(), calls.end(),
                          [](const auto& call) { return call.function == "clEnqueueMapBuffer"; }),
            50);
}

TEST_F(OpenClFailure, MappingFaultsAreSeen) {
  const cl::Context context(opencl_devices()[0]);
  const cl::CommandQueue queue(context, opencl_devices()[0]);
  cl::Program program(context, "kernel void set(global int *at) { *at = 1; }");
  ASSERT_EQ(program.build(), CL_SUCCESS);
  cl::Kernel kernel(program, "set");
  cl::Buffer memory(context, CL_MEM_READ_WRITE, sizeof(cl_int));
  const auto launch = [&] {
    kernel.setArg(0, memory);
    queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(1));
    queue.finish();
  };
  const auto map = [&](cl_map_flags flags) {
    return queue.enqueueMapBuffer(memory, CL_TRUE, flags, 0, sizeof(cl_int));
  };
  void* at = map(CL_MAP_READ);
  launch();
  queue.enqueueUnmapMemObject(memory, at);
  launch();
  EXPECT_EQ(failing::mapping_faults().size(), 0u);
  at = map(CL_MAP_WRITE);
  launch();
  EXPECT_EQ(failing::mapping_faults().size(), 1u);
  queue.enqueueFillBuffer(memory, 1, 0, sizeof(cl_int));
  EXPECT_EQ(failing::mapping_faults().size(), 2u);
  map(CL_MAP_READ);
  EXPECT_EQ(failing::mapping_faults().size(), 3u);
  queue.enqueueUnmapMemObject(memory, at);
  map(CL_MAP_READ);
  memory = {};
  EXPECT_EQ(failing::mapping_faults().size(), 4u);
}

TEST_F(OpenClFailure, DeviceWithoutDoublesServes) {
  failing::pretend(CL_DEVICE_DOUBLE_FP_CONFIG, 0);
  EXPECT_FALSE(list_opencl_devices()[0].doubles);
  EXPECT_EQ(convert_on("opencl").mesh.vertices, wanted().vertices);
}

/// With less memory in a buffer than one needs, and in all than is planned.
TEST_F(OpenClFailure, DeviceWithLittleMemoryIsLeftForTheCpu) {
  for (const cl_device_info property : {CL_DEVICE_MAX_MEM_ALLOC_SIZE, CL_DEVICE_GLOBAL_MEM_SIZE}) {
    failing::reset();
    failing::pretend(property, 10000);
    const Result result = convert_on("opencl");
    EXPECT_TRUE(fell_back(result.report));
    EXPECT_EQ(result.mesh.vertices, wanted().vertices);
    EXPECT_EQ(result.mesh.triangles, wanted().triangles);
  }
}

TEST_F(OpenClFailure, TheLimitOfMemoryHoldsForAllBackendsTogether) {
  ContextOptions options = on_opencl();
  options.threads = 2;
  Context context = make_context(options);
  Parameters parameters;
  convert(volume().view(), parameters, context);
  std::size_t peak = 0;
  for (const auto& backend : context.backends) peak = std::max(peak, backend->bytes_peak());
  parameters.max_memory = static_cast<std::int64_t>(peak / 2);
  try {
    convert(volume().view(), parameters, context);
    FAIL() << "half of the memory is not enough";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::refused);
    EXPECT_NE(std::string(error.what()).find("--max-memory"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace vasamesh
