#pragma once

/// \file
/// A layer over OpenCL's functions, linked into a test in place of host/opencl/loader.cpp: it
/// passes calls on, counts them, and makes those fail that it is told to. The library needs no
/// switch for it, and a function that the layer lacks does not link.

#include <compare>
#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "opencl/check.h"

namespace vasamesh::failing_opencl {

inline constexpr std::size_t kForEver = std::numeric_limits<std::size_t>::max();

/// One call that was made: the function, and where in the program.
struct Call {
  std::string function;
  const void* site = nullptr;

  auto operator<=>(const Call&) const = default;
};

/// Forgets the calls made so far, and fails none of the next.
void reset();

/// As reset(), and fails the calls first .. first + count - 1 from now on, counted from 0.
void fail(std::size_t first, std::size_t count = 1);

/// As reset(), and fails the next call of that function from that place.
void fail_at(const Call& call);

/// The program ends with this code at the next call of that function, until reset().
inline constexpr int kExit = 99;
void exit_at(const std::string& function);

/// The calls since the last reset() or fail(), in order. Releases are counted, too.
std::vector<Call> calls();

/// Devices answer `value` when they are asked for a property of 32 or 64 bits, until reset().
void pretend(cl_device_info property, cl_ulong value);

/// What was done, since the last reset() or fail(), that mapped memory does not allow: it was
/// mapped twice, released, or used by a command while the host might write it.
std::vector<std::string> mapping_faults();

/// Programs are built with these options, too, until reset(): as by a driver that takes liberties.
void pretend_options(const std::string& options);

}  // namespace vasamesh::failing_opencl
