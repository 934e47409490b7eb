#pragma once

/// \file
/// The backends by name, for tests and benchmarks, and their copies as vectors.

#include <memory>
#include <string>
#include <vector>

#include "backend/backend.h"

namespace vasamesh {

/// "tbb"; "opencl_one_item" and "opencl_work_group", the two shapes of the OpenCL kernels, whatever
/// the device would get by itself: the first works in the host's memory, as on a CPU, the second in
/// memory of its own, as on a GPU. The last two are absent in a build without OpenCL.
std::vector<std::string> backend_names();

/// The backend of that name, or "opencl_small_group", whose items take several rows of a brick;
/// null where it needs an OpenCL device and there is none.
std::shared_ptr<Backend> open_backend(const std::string& name);

/// A buffer of the backend with the given values.
template <class T>
Buffer<T> to_backend(Backend& backend, const std::vector<T>& values) {
  Buffer<T> buffer(backend, values.size());
  backend.upload<T>(buffer.view(), values);
  return buffer;
}

/// The values of a view of the backend.
template <class T>
std::vector<std::remove_const_t<T>> to_host(Backend& backend, View<T> view) {
  std::vector<std::remove_const_t<T>> values(view.size);
  backend.download<std::remove_const_t<T>>(view, values);
  return values;
}

}  // namespace vasamesh
