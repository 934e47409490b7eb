#include "opencl/speed.h"

#include <algorithm>
#include <chrono>
#include <functional>

#include "opencl/opencl_backend.h"

namespace vasamesh {

namespace {

constexpr std::size_t kVector = 16;                      // floats an item's load takes
constexpr std::size_t kElements = std::size_t{1} << 24;  // 64 MiB an array
constexpr std::size_t kArithmeticItems = std::size_t{1} << 18;
constexpr int kLanes = 64, kRepeats = 7;
constexpr double kLongEnough = 0.02;  // seconds of one measurement

/// One device, opened for measuring.
class Bench {
 public:
  explicit Bench(const cl::Device& device)
      : context_(device),
        queue_(context_, device),
        programs_(context_, device, kOneItemShape, cache_for(device, {})) {
    refuse_lacking(device, kOneItemShape);
  }

  cl::Buffer buffer(std::size_t floats) {
    cl_int status = CL_SUCCESS;
    cl::Buffer made(context_, CL_MEM_READ_WRITE, floats * sizeof(cl_float), nullptr, &status);
    check(status, "a buffer of the speed's measure");
    check(queue_.enqueueFillBuffer(made, cl_float{1}, 0, floats * sizeof(cl_float)), "filling it");
    return made;
  }
  template <class... Arguments>
  double best_seconds(const char* name, std::size_t items, const Arguments&... arguments) {
    cl::Kernel& kernel = programs_.kernel(name);
    cl_uint index = 0;
    (check(kernel.setArg(index++, arguments), name), ...);
    double best = seconds(kernel, items);
    for (int repeat = 0; repeat < kRepeats; ++repeat) best = std::min(best, seconds(kernel, items));
    return best;
  }

 private:
  double seconds(const cl::Kernel& kernel, std::size_t items) {
    check(queue_.finish(), "measuring a device");
    const auto start = std::chrono::steady_clock::now();
    check(queue_.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items), cl::NDRange(64)),
          "measuring a device");
    check(queue_.finish(), "measuring a device");
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  cl::Context context_;
  cl::CommandQueue queue_;
  Programs programs_;
};

double bandwidth(Bench& bench) {
  const cl::Buffer a = bench.buffer(kElements), b = bench.buffer(kElements),
                   c = bench.buffer(kElements);
  return 12.0 * kElements / bench.best_seconds("speed_triad", kElements / kVector, a, b, c);
}

double arithmetic(Bench& bench) {
  const cl::Buffer results = bench.buffer(kVector * kArithmeticItems);
  for (cl_uint rounds = 64;; rounds *= 4) {
    const double seconds =
        bench.best_seconds("speed_arithmetic", kArithmeticItems, results, rounds);
    if (seconds > kLongEnough || rounds > (1u << 24))
      return 2.0 * kLanes * kArithmeticItems * rounds / seconds;
  }
}

}  // namespace

DeviceSpeed measure_opencl_speed(int device) {
  Bench bench(opencl_devices().at(static_cast<std::size_t>(device)));
  return {bandwidth(bench), arithmetic(bench)};
}

}  // namespace vasamesh
