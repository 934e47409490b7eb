/// \file
/// Copies to a device's own memory and back, through pinned blocks.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <stdexcept>
#include <vector>

#include "opencl/opencl_backend.h"
#include "opencl/pinned_copies.h"

namespace vasamesh {
namespace {

using Bytes = std::vector<unsigned char>;

constexpr std::size_t kBlock = 4 << 20;
constexpr std::size_t kOffset = 19;  // in the device's memory

Bytes random_bytes(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  Bytes bytes(count);
  std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<unsigned char>(random()); });
  return bytes;
}

class OpenClCopies : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::vector<cl::Device> devices = opencl_devices();
    if (devices.empty()) GTEST_SKIP() << "no OpenCL device here";
    context_ = cl::Context(devices[0]);
    queue_ = cl::CommandQueue(context_, devices[0]);
  }

  cl::Buffer memory(std::size_t bytes) {
    return cl::Buffer(context_, CL_MEM_READ_WRITE, kOffset + bytes);
  }

  /// What arrives in the device's memory, as the device's own copy says.
  Bytes read_plainly(const cl::Buffer& memory, std::size_t bytes) {
    Bytes found(bytes);
    EXPECT_EQ(queue_.enqueueReadBuffer(memory, CL_TRUE, kOffset, bytes, found.data()), CL_SUCCESS);
    return found;
  }

  cl::Context context_;
  cl::CommandQueue queue_;
};

TEST_F(OpenClCopies, OfAllLengthsArriveWhole) {
  PinnedCopies copies(context_, queue_, "device");
  for (const std::size_t bytes : {std::size_t{1}, std::size_t{1} << 16, (std::size_t{1} << 16) + 1,
                                  kBlock - 1, kBlock, kBlock + 1, 2 * kBlock, 3 * kBlock + 77}) {
    SCOPED_TRACE(bytes);
    const Bytes sent = random_bytes(bytes, 1), other = random_bytes(bytes, 2);
    const cl::Buffer memory = this->memory(bytes);
    copies.to_device(sent.data(), bytes, memory(), kOffset, {});
    EXPECT_EQ(read_plainly(memory, bytes), sent);
    EXPECT_EQ(queue_.enqueueWriteBuffer(memory, CL_TRUE, kOffset, bytes, other.data()), CL_SUCCESS);
    Bytes found(bytes);
    copies.to_host(memory(), kOffset, found.data(), bytes, {});
    EXPECT_EQ(found, other);
  }
}

/// A copy that is left on the way does not disturb the next.
TEST_F(OpenClCopies, CanBeStopped) {
  PinnedCopies copies(context_, queue_, "device");
  constexpr std::size_t kBytes = 5 * kBlock + 3;
  const Bytes sent = random_bytes(kBytes, 3);
  const cl::Buffer memory = this->memory(kBytes);
  Bytes found(kBytes);
  for (int at = 1; at <= 6; ++at) {
    int called = 0;
    const auto stop = [&] {
      if (++called == at) throw std::runtime_error("stopped");
    };
    EXPECT_THROW(copies.to_device(sent.data(), kBytes, memory(), kOffset, stop),
                 std::runtime_error);
    copies.to_device(sent.data(), kBytes, memory(), kOffset, {});
    EXPECT_EQ(read_plainly(memory, kBytes), sent);
    called = 0;
    EXPECT_THROW(copies.to_host(memory(), kOffset, found.data(), kBytes, stop), std::runtime_error);
    std::fill(found.begin(), found.end(), 0);
    copies.to_host(memory(), kOffset, found.data(), kBytes, {});
    EXPECT_EQ(found, sent);
  }
}

}  // namespace
}  // namespace vasamesh
