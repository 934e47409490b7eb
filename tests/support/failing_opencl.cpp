#include "support/failing_opencl.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>

namespace vasamesh::failing_opencl {

namespace {

struct State {
  std::mutex mutex;
  std::vector<Call> calls;
  std::size_t first = kForEver, count = 0;
  std::map<cl_device_info, cl_ulong> pretended;

  State() {
    const char* wanted = std::getenv("VASAMESH_FAIL_OPENCL");
    if (wanted && std::sscanf(wanted, "%zu %zu", &first, &count) != 2) std::abort();
  }
};

State& state() {
  static State state;
  return state;
}

/// Notes a call. \return whether it is to fail.
bool fails(const char* function, const void* site) {
  State& s = state();
  const std::scoped_lock lock(s.mutex);
  const std::size_t index = s.calls.size();
  s.calls.push_back({function, site});
  return index >= s.first && index - s.first < s.count;
}

/// Puts what is pretended over an answer.
void pretend_answer(cl_device_info property, std::size_t size, void* value) {
  State& s = state();
  const std::scoped_lock lock(s.mutex);
  const auto found = s.pretended.find(property);
  if (value && found != s.pretended.end())
    std::memcpy(value, &found->second, std::min(size, sizeof(cl_ulong)));
}

/// The loader's own function.
template <class Function>
Function* next(const char* name) {
  static void* const loader = dlopen("libOpenCL.so.1", RTLD_NOW);
  void* const function = loader ? dlsym(loader, name) : nullptr;
  if (!function) std::abort();
  return reinterpret_cast<Function*>(function);
}

}  // namespace

void fail(std::size_t first, std::size_t count) {
  State& s = state();
  const std::scoped_lock lock(s.mutex);
  s.calls.clear();
  s.pretended.clear();
  s.first = first;
  s.count = count;
}

void reset() { fail(kForEver, 0); }

std::vector<Call> calls() {
  State& s = state();
  const std::scoped_lock lock(s.mutex);
  return s.calls;
}

void pretend(cl_device_info property, cl_ulong value) {
  State& s = state();
  const std::scoped_lock lock(s.mutex);
  s.pretended[property] = value;
}

}  // namespace vasamesh::failing_opencl

using vasamesh::failing_opencl::fails;
using vasamesh::failing_opencl::next;
using vasamesh::failing_opencl::pretend_answer;

// A function that answers by its status, and one that makes an object and writes its status. Where
// a thing is given back that happens in any case, so that no test leaks.

#define STATUS(name, parameters, arguments)                                    \
  cl_int name parameters {                                                     \
    static auto* const real = next<decltype(name)>(#name);                     \
    if (fails(#name, __builtin_return_address(0))) return CL_OUT_OF_RESOURCES; \
    return real arguments;                                                     \
  }
#define RELEASE(name, Object)                                                        \
  cl_int name(Object object) {                                                       \
    static auto* const real = next<decltype(name)>(#name);                           \
    const cl_int status = real(object);                                              \
    return fails(#name, __builtin_return_address(0)) ? CL_OUT_OF_RESOURCES : status; \
  }
#define OBJECT(Type, name, parameters, arguments)                          \
  Type name parameters {                                                   \
    static auto* const real = next<decltype(name)>(#name);                 \
    if (!fails(#name, __builtin_return_address(0))) return real arguments; \
    if (status) *status = CL_OUT_OF_RESOURCES;                             \
    return nullptr;                                                        \
  }

extern "C" {

STATUS(clGetPlatformIDs, (cl_uint count, cl_platform_id* platforms, cl_uint* found),
       (count, platforms, found))
STATUS(clGetPlatformInfo,
       (cl_platform_id platform, cl_platform_info property, size_t size, void* value,
        size_t* wrote),
       (platform, property, size, value, wrote))
STATUS(clGetDeviceIDs,
       (cl_platform_id platform, cl_device_type type, cl_uint count, cl_device_id* devices,
        cl_uint* found),
       (platform, type, count, devices, found))
cl_int clGetDeviceInfo(cl_device_id device, cl_device_info property, size_t size, void* value,
                       size_t* wrote) {
  static auto* const real = next<decltype(clGetDeviceInfo)>("clGetDeviceInfo");
  if (fails("clGetDeviceInfo", __builtin_return_address(0))) return CL_OUT_OF_RESOURCES;
  const cl_int status = real(device, property, size, value, wrote);
  if (status == CL_SUCCESS) pretend_answer(property, size, value);
  return status;
}

OBJECT(cl_context, clCreateContext,
       (const cl_context_properties* properties, cl_uint count, const cl_device_id* devices,
        void(CL_CALLBACK* notify)(const char*, const void*, size_t, void*), void* user,
        cl_int* status),
       (properties, count, devices, notify, user, status))
OBJECT(cl_command_queue, clCreateCommandQueue,
       (cl_context context, cl_device_id device, cl_command_queue_properties properties,
        cl_int* status),
       (context, device, properties, status))
OBJECT(cl_mem, clCreateBuffer,
       (cl_context context, cl_mem_flags flags, size_t size, void* host, cl_int* status),
       (context, flags, size, host, status))
OBJECT(cl_program, clCreateProgramWithSource,
       (cl_context context, cl_uint count, const char** strings, const size_t* lengths,
        cl_int* status),
       (context, count, strings, lengths, status))
OBJECT(cl_program, clCreateProgramWithBinary,
       (cl_context context, cl_uint count, const cl_device_id* devices, const size_t* lengths,
        const unsigned char** binaries, cl_int* binary_status, cl_int* status),
       (context, count, devices, lengths, binaries, binary_status, status))
OBJECT(cl_kernel, clCreateKernel, (cl_program program, const char* name, cl_int* status),
       (program, name, status))

STATUS(clBuildProgram,
       (cl_program program, cl_uint count, const cl_device_id* devices, const char* options,
        void(CL_CALLBACK* notify)(cl_program, void*), void* user),
       (program, count, devices, options, notify, user))
STATUS(clGetProgramInfo,
       (cl_program program, cl_program_info property, size_t size, void* value, size_t* wrote),
       (program, property, size, value, wrote))
STATUS(clGetProgramBuildInfo,
       (cl_program program, cl_device_id device, cl_program_build_info property, size_t size,
        void* value, size_t* wrote),
       (program, device, property, size, value, wrote))
STATUS(clGetKernelInfo,
       (cl_kernel kernel, cl_kernel_info property, size_t size, void* value, size_t* wrote),
       (kernel, property, size, value, wrote))
STATUS(clGetKernelWorkGroupInfo,
       (cl_kernel kernel, cl_device_id device, cl_kernel_work_group_info property, size_t size,
        void* value, size_t* wrote),
       (kernel, device, property, size, value, wrote))
STATUS(clSetKernelArg, (cl_kernel kernel, cl_uint index, size_t size, const void* value),
       (kernel, index, size, value))

STATUS(clEnqueueNDRangeKernel,
       (cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t* offset,
        const size_t* global, const size_t* local, cl_uint waits, const cl_event* wait,
        cl_event* event),
       (queue, kernel, dimensions, offset, global, local, waits, wait, event))
STATUS(clEnqueueFillBuffer,
       (cl_command_queue queue, cl_mem buffer, const void* pattern, size_t pattern_size,
        size_t offset, size_t size, cl_uint waits, const cl_event* wait, cl_event* event),
       (queue, buffer, pattern, pattern_size, offset, size, waits, wait, event))
STATUS(clEnqueueReadBuffer,
       (cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t size,
        void* to, cl_uint waits, const cl_event* wait, cl_event* event),
       (queue, buffer, blocking, offset, size, to, waits, wait, event))
STATUS(clEnqueueWriteBuffer,
       (cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t size,
        const void* from, cl_uint waits, const cl_event* wait, cl_event* event),
       (queue, buffer, blocking, offset, size, from, waits, wait, event))
STATUS(clEnqueueCopyBuffer,
       (cl_command_queue queue, cl_mem from, cl_mem to, size_t from_offset, size_t to_offset,
        size_t size, cl_uint waits, const cl_event* wait, cl_event* event),
       (queue, from, to, from_offset, to_offset, size, waits, wait, event))
OBJECT(void*, clEnqueueMapBuffer,
       (cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags flags, size_t offset,
        size_t size, cl_uint waits, const cl_event* wait, cl_event* event, cl_int* status),
       (queue, buffer, blocking, flags, offset, size, waits, wait, event, status))
STATUS(clEnqueueUnmapMemObject,
       (cl_command_queue queue, cl_mem memory, void* pointer, cl_uint waits, const cl_event* wait,
        cl_event* event),
       (queue, memory, pointer, waits, wait, event))
STATUS(clEnqueueMarkerWithWaitList,
       (cl_command_queue queue, cl_uint waits, const cl_event* wait, cl_event* event),
       (queue, waits, wait, event))
STATUS(clSetEventCallback,
       (cl_event event, cl_int when, void(CL_CALLBACK* notify)(cl_event, cl_int, void*),
        void* user),
       (event, when, notify, user))
STATUS(clGetEventInfo,
       (cl_event event, cl_event_info property, size_t size, void* value, size_t* wrote),
       (event, property, size, value, wrote))
STATUS(clFlush, (cl_command_queue queue), (queue))
STATUS(clFinish, (cl_command_queue queue), (queue))

RELEASE(clReleaseCommandQueue, cl_command_queue)
RELEASE(clReleaseContext, cl_context)
RELEASE(clReleaseDevice, cl_device_id)
RELEASE(clReleaseEvent, cl_event)
RELEASE(clReleaseKernel, cl_kernel)
RELEASE(clReleaseMemObject, cl_mem)
RELEASE(clReleaseProgram, cl_program)
RELEASE(clRetainCommandQueue, cl_command_queue)
RELEASE(clRetainContext, cl_context)
RELEASE(clRetainDevice, cl_device_id)
RELEASE(clRetainEvent, cl_event)
RELEASE(clRetainKernel, cl_kernel)
RELEASE(clRetainMemObject, cl_mem)
RELEASE(clRetainProgram, cl_program)

}  // extern "C"
