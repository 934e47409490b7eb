/// Devices: their list, their choice, and the Contexts made of them.

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "backend/backend.h"
#include "device_choice.h"
#include "opencl/backend.h"
#include "opencl/tuning.h"
#include "support/environment.h"
#include "support/scratch.h"
#include "vasamesh/errors.h"
#include "vasamesh/host.h"

namespace vasamesh {
namespace {

ContextOptions asked(const std::string& backend, const std::string& device = "") {
  ContextOptions options;
  options.backend = backend;
  options.device = device;
  options.threads = 2;
  return options;
}

std::string refusal(const ContextOptions& options, ErrorCode code) {
  try {
    make_context(options);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "accepted";
  return "";
}

std::string first_backend(const ContextOptions& options) {
  return make_context(options).backends.front()->name();
}

class Devices : public ::testing::Test {
 protected:
  void SetUp() override { unsetenv("VASAMESH_DEVICE"); }
};

class OpenClDevices : public Devices {
 protected:
  void SetUp() override {
    Devices::SetUp();
    if (list_opencl_devices().empty()) GTEST_SKIP() << "no OpenCL device here";
  }
};

TEST_F(Devices, TheProcessorIsNumberZero) {
  const auto devices = list_devices();
  ASSERT_EQ(devices.size(), 1 + list_opencl_devices().size());
  EXPECT_EQ(devices[0].type, "cpu");
  EXPECT_GT(devices[0].memory, 0);
  for (std::size_t i = 0; i < devices.size(); ++i) {
    EXPECT_EQ(devices[i].number, static_cast<int>(i));
    EXPECT_FALSE(devices[i].name.empty());
    EXPECT_FALSE(devices[i].driver.empty());
    EXPECT_GE(devices[i].compute_units, 1);
    EXPECT_EQ(devices[i].backend, i == 0 ? "tbb" : "opencl");
  }
}

TEST_F(Devices, AutoIsTbb) {
  const Context context = make_context(asked("auto"));
  ASSERT_EQ(context.backends.size(), 1u);
  EXPECT_EQ(context.backends[0]->name(), "tbb");
  EXPECT_NE(context.backends[0]->device().find("2 threads"), std::string::npos);
}

TEST_F(Devices, WrongUse) {
  EXPECT_NE(refusal(asked("cuda"), ErrorCode::usage).find("auto, tbb or opencl"),
            std::string::npos);
  ContextOptions options = asked("tbb");
  options.threads = -1;
  EXPECT_NE(refusal(options, ErrorCode::usage).find("--threads"), std::string::npos);
}

TEST_F(Devices, NameThatFitsNoneNamesTheChoices) {
  const std::string message = refusal(asked("auto", "no such thing"), ErrorCode::no_device);
  EXPECT_NE(message.find("\"no such thing\" fits no device"), std::string::npos) << message;
  for (const DeviceInfo& device : list_devices())
    EXPECT_NE(message.find(device.name), std::string::npos) << message;
  refusal(asked("tbb", "gpu"), ErrorCode::no_device);
  refusal(asked("tbb", "1"), ErrorCode::no_device);
  refusal(asked("opencl", "0"), ErrorCode::no_device);
}

TEST_F(Devices, NumberTypeAndNameChoose) {
  EXPECT_EQ(first_backend(asked("auto", "0")), "tbb");
  EXPECT_EQ(first_backend(asked("auto", "CPU")), "tbb");
  EXPECT_EQ(first_backend(asked("tbb", list_devices()[0].name)), "tbb");
}

/// Two of one name, one whose name holds the other's number, a second CPU.
std::vector<DeviceInfo> made_up_devices() {
  const auto device = [](int number, const char* type, const char* name) {
    DeviceInfo info;
    info.number = number;
    info.backend = number == 0 ? "tbb" : "opencl";
    info.type = type;
    info.name = name;
    return info;
  };
  return {device(0, "cpu", "Xeon 3"), device(1, "gpu", "Tesla T4"), device(3, "gpu", "Tesla T4"),
          device(4, "cpu", "Xeon"), device(5, "accelerator", "Phi of cpu 9")};
}

TEST(DeviceChoice, NumberThenTypeThenName) {
  const auto chosen = [](const char* wanted) {
    return choose_device(made_up_devices(), wanted, "--device").number;
  };
  EXPECT_EQ(chosen("3"), 3) << "a number, though a name holds it";
  EXPECT_EQ(chosen("cpu"), 0) << "the first of the type, though a name holds it";
  EXPECT_EQ(chosen("GPU"), 1);
  EXPECT_EQ(chosen("accelerator"), 5);
  EXPECT_EQ(chosen("PHI"), 5);
  EXPECT_EQ(chosen("xeon 3"), 0);
}

TEST(DeviceChoice, SeveralOrNoneAreRefused) {
  const auto message = [](const char* wanted) -> std::string {
    try {
      choose_device(made_up_devices(), wanted, "VASAMESH_DEVICE");
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::no_device);
      return error.what();
    }
    return "";
  };
  const std::string several = message("tesla");
  EXPECT_NE(several.find("VASAMESH_DEVICE: \"tesla\" fits several"), std::string::npos) << several;
  EXPECT_NE(several.find("1 (opencl, gpu, Tesla T4), 3 (opencl"), std::string::npos) << several;
  EXPECT_EQ(several.find("Phi"), std::string::npos) << several;
  EXPECT_NE(message("2").find("fits no device"), std::string::npos) << "a gap in the numbers";
  EXPECT_NE(message("-1").find("fits no device"), std::string::npos);
}

TEST_F(Devices, VariableIsTheDefault) {
  {
    const Variable variable("VASAMESH_DEVICE", "nothing like it");
    EXPECT_NE(refusal(asked("auto"), ErrorCode::no_device).find("VASAMESH_DEVICE"),
              std::string::npos);
    EXPECT_EQ(first_backend(asked("tbb")), "tbb") << "a default only";
    EXPECT_EQ(first_backend(asked("auto", "0")), "tbb");
  }
  const Variable variable("VASAMESH_DEVICE", "0");
  EXPECT_EQ(first_backend(asked("auto")), "tbb");
}

TEST_F(OpenClDevices, AskedForByNameIsWhatRuns) {
  const Context context = make_context(asked("opencl"));
  ASSERT_EQ(context.backends.size(), 2u);
  EXPECT_EQ(context.backends[0]->name(), "opencl");
  EXPECT_EQ(context.backends[0]->device(), list_opencl_devices()[0].name);
  EXPECT_TRUE(context.backends[0]->offers(Stage::poisson));
  EXPECT_EQ(context.backends[1]->name(), "tbb");
}

TEST_F(OpenClDevices, NumberAndVariableChoose) {
  EXPECT_EQ(first_backend(asked("auto", "1")), "opencl");
  const Variable variable("VASAMESH_DEVICE", "1");
  EXPECT_EQ(first_backend(asked("auto")), "opencl");
  EXPECT_EQ(first_backend(asked("tbb")), "tbb") << "the variable is a default only";
}

TEST_F(OpenClDevices, NameThatFitsSeveralNamesThem) {
  const auto devices = list_devices();
  const std::string message = refusal(asked("auto", " "), ErrorCode::no_device);
  EXPECT_NE(message.find("fits several devices"), std::string::npos) << message;
}

TEST_F(OpenClDevices, IndexOutOfRange) {
  OpenClOptions options;
  options.device = 1000;
  try {
    make_opencl_backend(options);
    FAIL() << "there are not so many";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::no_device);
  }
}

TEST_F(OpenClDevices, OffersAllStagesWithKernels) {
  const auto backend = make_opencl_backend({});
  EXPECT_TRUE(backend->offers(Stage::sizing));
  EXPECT_TRUE(backend->offers(Stage::expand));
  EXPECT_TRUE(backend->offers(Stage::stitch));
  EXPECT_TRUE(backend->offers(Stage::relax));
  EXPECT_TRUE(backend->offers(Stage::verify));
  EXPECT_FALSE(backend->offers(Stage::mesh));
}

TEST_F(OpenClDevices, BufferLargerThanTheDeviceGivesIsRefused) {
  const auto backend = make_opencl_backend({});
  try {
    backend->allocate(std::size_t{1} << 50);
    FAIL() << "a petabyte";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::refused);
    EXPECT_NE(std::string(error.what()).find(backend->device()), std::string::npos);
  }
  EXPECT_EQ(backend->bytes_held(), 0u);
}

TEST_F(OpenClDevices, TuningIsRememberedAndUsed) {
  const Scratch folder;
  const std::string cache = folder / "cache";
  EXPECT_FALSE(load_shape(0, cache));
  EXPECT_FALSE(load_worth(0, cache, "a processor"));
  const WorkShape shape = {32, 128, 8, 256, 128};
  const DeviceWorth worth = {bit_of(Stage::poisson) | bit_of(Stage::lattice), ""};
  const DeviceWorth none = {0, "it was slower"};
  EXPECT_TRUE(store_shape(0, cache, shape));
  EXPECT_TRUE(store_worth(0, cache, "a processor", worth));
  EXPECT_TRUE(store_worth(0, cache, "another processor", none));
  ASSERT_TRUE(load_shape(0, cache));
  EXPECT_EQ(*load_shape(0, cache), shape);
  EXPECT_EQ(load_worth(0, cache, "a processor"), worth);
  EXPECT_EQ(load_worth(0, cache, "another processor"), none);
  EXPECT_FALSE(load_worth(0, cache, "a third processor"));
  forget_worth(0, cache, "a processor");
  EXPECT_FALSE(load_worth(0, cache, "a processor"));
  EXPECT_TRUE(load_shape(0, cache));
}

TEST_F(OpenClDevices, TuningThatCannotBeKeptIsSaidSo) {
  EXPECT_FALSE(store_shape(0, "/proc/none", kOneItemShape));
  EXPECT_FALSE(store_worth(0, "/proc/none", "a processor", {}));
}

TEST_F(OpenClDevices, StagesCanBeLeftToOthers) {
  OpenClOptions options;
  options.stages = bit_of(Stage::poisson);
  const auto backend = make_opencl_backend(options);
  EXPECT_TRUE(backend->offers(Stage::poisson));
  EXPECT_FALSE(backend->offers(Stage::points));
  EXPECT_FALSE(backend->offers(Stage::mesh));
}

TEST(Shapes, AreAllDifferent) {
  const std::vector<WorkShape> shapes = shapes_to_try();
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(shapes[i] == shapes[j]);
  EXPECT_GE(shapes.size(), 8u);
}

}  // namespace
}  // namespace vasamesh
