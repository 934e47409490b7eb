#include "support/failing_opencl.h"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <optional>
#include <string_view>
#include <type_traits>

namespace vasamesh::failing_opencl {

namespace {

struct State {
  std::mutex mutex;
  std::vector<Call> calls;
  std::size_t first = kForEver, count = 0;
  std::optional<Call> wanted;
  std::string last;  // at which the program ends
  std::map<cl_device_info, cl_ulong> pretended;
  std::string options;
  std::map<cl_mem, cl_map_flags> mapped;
  std::map<cl_kernel, std::map<cl_uint, cl_mem>> arguments;  // those that may be memory
  std::vector<std::string> mapping_faults;
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
  if (s.last == function) _exit(kExit);
  if (s.wanted == s.calls.back()) {
    s.wanted.reset();
    return true;
  }
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
Function* real_function(const char* name) {
  static void* const loader = dlopen("libOpenCL.so.1", RTLD_NOW);
  void* const function = loader ? dlsym(loader, name) : nullptr;
  if (!function) std::abort();
  return reinterpret_cast<Function*>(function);
}

cl_int build_as_pretended(cl_program program, cl_uint count, const cl_device_id* devices,
                          const char* options, void (*notify)(cl_program, void*), void* data) {
  static auto* const build = real_function<decltype(clBuildProgram)>("clBuildProgram");
  std::string all = options ? options : "";
  {
    const std::scoped_lock lock(state().mutex);
    all += " " + state().options;
  }
  return build(program, count, devices, all.c_str(), notify, data);
}

void* map_and_note(cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags flags,
                   size_t offset, size_t size, cl_uint waits, const cl_event* wait, cl_event* event,
                   cl_int* status) {
  static auto* const map = real_function<decltype(clEnqueueMapBuffer)>("clEnqueueMapBuffer");
  void* const at = map(queue, buffer, blocking, flags, offset, size, waits, wait, event, status);
  State& s = state();
  const std::scoped_lock lock(s.mutex);
  if (at && !s.mapped.try_emplace(buffer, flags).second) s.mapping_faults.push_back("mapped twice");
  return at;
}

cl_int unmap_and_note(cl_command_queue queue, cl_mem memory, void* pointer, cl_uint waits,
                      const cl_event* wait, cl_event* event) {
  static auto* const unmap =
      real_function<decltype(clEnqueueUnmapMemObject)>("clEnqueueUnmapMemObject");
  const cl_int status = unmap(queue, memory, pointer, waits, wait, event);
  const std::scoped_lock lock(state().mutex);
  if (status == CL_SUCCESS) state().mapped.erase(memory);
  return status;
}

cl_int release_and_note(cl_mem memory) {
  static auto* const release = real_function<decltype(clReleaseMemObject)>("clReleaseMemObject");
  {
    State& s = state();
    const std::scoped_lock lock(s.mutex);
    if (s.mapped.erase(memory)) s.mapping_faults.push_back("released mapped");
  }
  return release(memory);
}

void note_command_on(cl_mem memory) {
  State& s = state();
  const std::scoped_lock lock(s.mutex);
  const auto found = s.mapped.find(memory);
  if (found != s.mapped.end() && found->second & CL_MAP_WRITE)
    s.mapping_faults.push_back("a command on what is mapped for writing");
}

cl_int fill_and_note(cl_command_queue queue, cl_mem buffer, const void* pattern,
                     size_t pattern_size, size_t offset, size_t size, cl_uint waits,
                     const cl_event* wait, cl_event* event) {
  static auto* const fill = real_function<decltype(clEnqueueFillBuffer)>("clEnqueueFillBuffer");
  note_command_on(buffer);
  return fill(queue, buffer, pattern, pattern_size, offset, size, waits, wait, event);
}

cl_int set_and_note(cl_kernel kernel, cl_uint index, size_t size, const void* value) {
  static auto* const set = real_function<decltype(clSetKernelArg)>("clSetKernelArg");
  {
    const std::scoped_lock lock(state().mutex);
    cl_mem& memory = state().arguments[kernel][index];
    memory = nullptr;
    if (value && size == sizeof(memory)) std::memcpy(&memory, value, size);
  }
  return set(kernel, index, size, value);
}

cl_int launch_and_note(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions,
                       const size_t* offset, const size_t* global, const size_t* local,
                       cl_uint waits, const cl_event* wait, cl_event* event) {
  static auto* const launch =
      real_function<decltype(clEnqueueNDRangeKernel)>("clEnqueueNDRangeKernel");
  std::map<cl_uint, cl_mem> arguments;
  {
    const std::scoped_lock lock(state().mutex);
    arguments = state().arguments[kernel];
  }
  for (const auto& [index, memory] : arguments) note_command_on(memory);
  return launch(queue, kernel, dimensions, offset, global, local, waits, wait, event);
}

/// What a call is passed on to.
template <class Function>
Function* next(const char* name) {
  if constexpr (std::is_same_v<Function, decltype(clBuildProgram)>) return build_as_pretended;
  if constexpr (std::is_same_v<Function, decltype(clEnqueueMapBuffer)>) return map_and_note;
  if constexpr (std::is_same_v<Function, decltype(clEnqueueUnmapMemObject)>) return unmap_and_note;
  if constexpr (std::is_same_v<Function, decltype(clSetKernelArg)>) return set_and_note;
  if constexpr (std::is_same_v<Function, decltype(clEnqueueNDRangeKernel)>) return launch_and_note;
  if constexpr (std::is_same_v<Function, decltype(clEnqueueFillBuffer)>) return fill_and_note;
  if constexpr (std::is_same_v<Function, decltype(clReleaseMemObject)>)
    if (std::string_view(name) == "clReleaseMemObject") return release_and_note;
  return real_function<Function>(name);
}

}  // namespace

void fail(std::size_t first, std::size_t count) {
  State& s = state();
  const std::scoped_lock lock(s.mutex);
  s.calls.clear();
  s.pretended.clear();
  s.options.clear();
  s.mapping_faults.clear();
  s.wanted.reset();
  s.last.clear();
  s.first = first;
  s.count = count;
}

void fail_at(const Call& call) {
  reset();
  const std::scoped_lock lock(state().mutex);
  state().wanted = call;
}

void exit_at(const std::string& function) {
  reset();
  const std::scoped_lock lock(state().mutex);
  state().last = function;
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

std::vector<std::string> mapping_faults() {
  const std::scoped_lock lock(state().mutex);
  return state().mapping_faults;
}

void pretend_options(const std::string& options) {
  State& s = state();
  const std::scoped_lock lock(s.mutex);
  s.options = options;
}

}  // namespace vasamesh::failing_opencl

using vasamesh::failing_opencl::fails;
using vasamesh::failing_opencl::next;
using vasamesh::failing_opencl::pretend_answer;

// What keeps objects, gives them back or waits for their end happens in any case, so that no test
// leaks, and a device that has failed does not work on.

#define STATUS(name, parameters, arguments)                                    \
  cl_int name parameters {                                                     \
    static auto* const real = next<decltype(name)>(#name);                     \
    if (fails(#name, __builtin_return_address(0))) return CL_OUT_OF_RESOURCES; \
    return real arguments;                                                     \
  }
#define QUESTION(name, Object, Property)                                                   \
  cl_int name(Object object, Property property, size_t size, void* value, size_t* wrote) { \
    static auto* const real = next<decltype(name)>(#name);                                 \
    if (fails(#name, __builtin_return_address(0))) return CL_OUT_OF_RESOURCES;             \
    const cl_int status = real(object, property, size, value, wrote);                      \
    if (std::is_same_v<Object, cl_device_id>) pretend_answer(property, size, value);       \
    return status;                                                                         \
  }
#define COUNT(name, Object)                                                          \
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
#include "opencl/functions.def"
}
