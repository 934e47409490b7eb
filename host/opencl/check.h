#pragma once

/// \file
/// OpenCL's headers as this backend uses them, and its status codes as Error.

#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#include <CL/opencl.hpp>
#include <string>

namespace vasamesh {

/// "CL_OUT_OF_RESOURCES (-5)".
std::string status_name(cl_int status);

/// Nothing for CL_SUCCESS. \param what  what was tried and on which device, for the message.
/// \throws DeviceFailure refused for memory that is not to be had, no_device for a device that is
///         gone, internal otherwise.
void check(cl_int status, const std::string& what);

/// A property of a device or a platform. \throws DeviceFailure where it does not answer.
template <cl_uint Property, class Object>
auto ask(const Object& object) {
  cl_int status = CL_SUCCESS;
  auto answer = object.template getInfo<Property>(&status);
  check(status, "asking an OpenCL device");
  return answer;
}

}  // namespace vasamesh
