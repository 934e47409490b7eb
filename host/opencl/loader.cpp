/// The entry to OpenCL: each function that the backend calls finds the one of that name in the
/// system's OpenCL loader, which is opened by the first call. The program starts without a loader;
/// then there are no platforms. The build keeps these names within the program that links them.

#include <dlfcn.h>

#include "opencl/check.h"

namespace {

constexpr char kLoader[] = "libOpenCL.so.1";
constexpr cl_int kNoPlatform = -1001;  // CL_PLATFORM_NOT_FOUND_KHR

/// The loader's function, or null.
template <class Function>
Function* find(const char* name) {
  static void* const loader = dlopen(kLoader, RTLD_NOW | RTLD_LOCAL);
  return loader ? reinterpret_cast<Function*>(dlsym(loader, name)) : nullptr;
}

}  // namespace

#define STATUS(name, parameters, arguments)                \
  cl_int name parameters {                                 \
    static auto* const real = find<decltype(name)>(#name); \
    return real ? real arguments : kNoPlatform;            \
  }
#define QUESTION(name, Object, Property)                                                    \
  STATUS(name, (Object object, Property property, size_t size, void* value, size_t* wrote), \
         (object, property, size, value, wrote))
#define COUNT(name, Object) STATUS(name, (Object object), (object))
#define OBJECT(Type, name, parameters, arguments)          \
  Type name parameters {                                   \
    static auto* const real = find<decltype(name)>(#name); \
    if (real) return real arguments;                       \
    if (status) *status = kNoPlatform;                     \
    return nullptr;                                        \
  }

extern "C" {
#include "opencl/functions.def"
}
