#include "opencl/arithmetic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>

namespace vasamesh {

namespace {

constexpr std::size_t kProbes = 256;
constexpr float kAboveOne = 1.0f + 0x1p-12f;

/// What is asked for: a * b + c, a / b and the square root of a.
struct Operands {
  cl_float a, b, c;
};
struct Results {
  cl_float sum, quotient, root;
  bool operator==(const Results&) const = default;
};

constexpr std::size_t kFirstSubnormal = 1;
constexpr Operands kHardSums[] = {
    {kAboveOne, kAboveOne, -(1.0f + 0x1p-11f)},  // the product's last bit is rounded off
    {0x1p-100f, 0x1p-30f, 0.0f},                 // a sub-normal product
    {0x1p-130f, 0x1p20f, 0.0f},                  // a sub-normal factor
    {0x1p-130f, 1.0f, 0x1p-131f}};               // a sub-normal sum

/// These, and numbers between 1 and 3, of whose quotients and roots some in ten would be wrong in
/// the last bit if they were made of reciprocals.
std::array<Operands, kProbes> probes() {
  std::array<Operands, kProbes> probes;
  std::uint32_t state = 1;
  const auto next = [&state] {
    state = 1664525u * state + 1013904223u;
    return 1.0f + 0x1p-23f * static_cast<float>(state >> 8);
  };
  for (Operands& probe : probes) probe = {next(), next(), next()};
  std::copy(std::begin(kHardSums), std::end(kHardSums), probes.begin());
  return probes;
}

Results specified(const Operands& of) { return {of.a * of.b + of.c, of.a / of.b, std::sqrt(of.a)}; }

/// \throws DeviceFailure
std::array<Results, kProbes> ask_device(const cl::Context& context, const cl::CommandQueue& queue,
                                        Programs& programs,
                                        std::array<Operands, kProbes> operands) {
  cl_int status = CL_SUCCESS;
  const cl::Buffer in(context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, sizeof(operands),
                      operands.data(), &status);
  check(status, "a buffer of the arithmetic's probe");
  std::array<Results, kProbes> got{};
  const cl::Buffer out(context, CL_MEM_WRITE_ONLY, sizeof(got), nullptr, &status);
  check(status, "a buffer of the arithmetic's probe");
  cl::Kernel& kernel = programs.kernel("primitives_probe");
  check(kernel.setArg(0, in), "setting an argument of the arithmetic's probe");
  check(kernel.setArg(1, out), "setting an argument of the arithmetic's probe");
  check(queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(kProbes), cl::NDRange(1)),
        "the arithmetic's probe");
  check(queue.enqueueReadBuffer(out, CL_TRUE, 0, sizeof(got), got.data()),
        "reading the arithmetic's probe");
  return got;
}

}  // namespace

std::string other_arithmetic(const cl::Context& context, const cl::CommandQueue& queue,
                             Programs& programs) {
  const std::array<Operands, kProbes> operands = probes();
  const std::array<Results, kProbes> got = ask_device(context, queue, programs, operands);
  bool contracts = false, drops = false, quotients = false, roots = false;
  for (std::size_t i = 0; i < kProbes; ++i) {
    const Results wanted = specified(operands[i]);
    if (i >= kFirstSubnormal && i < std::size(kHardSums)) {
      drops |= got[i] != wanted;
      continue;
    }
    contracts |= got[i].sum != wanted.sum;
    quotients |= got[i].quotient != wanted.quotient;
    roots |= got[i].root != wanted.root;
  }
  std::string words;
  const auto say = [&words](bool is_so, const char* what) {
    if (is_so) words += (words.empty() ? "" : ", ") + std::string(what);
  };
  say(contracts, "contracts products");
  say(drops, "drops sub-normal numbers");
  say(quotients, "rounds quotients otherwise than IEEE 754");
  say(roots, "rounds square roots otherwise than IEEE 754");
  return words;
}

}  // namespace vasamesh
