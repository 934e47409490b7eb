#include "opencl/arithmetic.h"

#include <array>

namespace vasamesh {

namespace {

constexpr int kProbes = 4;
constexpr float kAboveOne = 1.0f + 0x1p-12f;

/// a * b + c of each, and what it is without contraction and with sub-normals.
constexpr std::array<cl_float, 3 * kProbes> kFactors = {
    kAboveOne, kAboveOne, -(1.0f + 0x1p-11f),  // the product's last bit is rounded off
    0x1p-100f, 0x1p-30f,  0.0f,                // a sub-normal product
    0x1p-130f, 0x1p20f,   0.0f,                // a sub-normal factor
    0x1p-130f, 1.0f,      0x1p-131f};          // a sub-normal sum
constexpr std::array<cl_float, kProbes> kWanted = {0.0f, 0x1p-130f, 0x1p-110f,
                                                   0x1p-130f + 0x1p-131f};

}  // namespace

bool arithmetic_as_specified(const cl::Context& context, const cl::CommandQueue& queue,
                             Programs& programs) {
  cl_int status = CL_SUCCESS;
  std::array<cl_float, 3 * kProbes> factors = kFactors;
  const cl::Buffer in(context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, sizeof(factors),
                      factors.data(), &status);
  check(status, "a buffer of the arithmetic's probe");
  const cl::Buffer out(context, CL_MEM_WRITE_ONLY, sizeof(kWanted), nullptr, &status);
  check(status, "a buffer of the arithmetic's probe");
  cl::Kernel& kernel = programs.kernel("primitives_probe");
  check(kernel.setArg(0, in), "setting an argument of the arithmetic's probe");
  check(kernel.setArg(1, out), "setting an argument of the arithmetic's probe");
  check(queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(kProbes), cl::NDRange(1)),
        "the arithmetic's probe");
  std::array<cl_float, kProbes> got{};
  check(queue.enqueueReadBuffer(out, CL_TRUE, 0, sizeof(got), got.data()),
        "reading the arithmetic's probe");
  return got == kWanted;
}

}  // namespace vasamesh
