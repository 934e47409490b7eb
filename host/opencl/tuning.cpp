#include <sstream>

#include "opencl/opencl_backend.h"
#include "opencl/program_cache.h"
#include "opencl/work_shape.h"

namespace vasamesh {

namespace {

/// Everything that a tuning depends on.
std::string key_of(int number) {
  const cl::Device device = opencl_devices().at(static_cast<std::size_t>(number));
  std::string key = "tuning 1\n" + ask<CL_DEVICE_NAME>(device) + "\n" +
                    ask<CL_DRIVER_VERSION>(device) + "\n" + ask<CL_DEVICE_VERSION>(device) + "\n";
  for (const KernelSource& source : kernel_sources()) key += source.text;
  return key;
}

}  // namespace

std::vector<WorkShape> shapes_to_try() {
  std::vector<WorkShape> shapes;
  for (const int brick : {1, 64})
    for (const int fold : {32, 64, 128, 256}) {
      WorkShape shape = brick == 1 ? kOneItemShape : kWorkGroupShape;
      shape.brick_items = brick;
      shape.fold_items = fold;
      shapes.push_back(shape);
    }
  return shapes;
}

std::optional<Tuning> load_tuning(int device, const std::string& cache_folder) {
  const std::optional<std::string> text = ProgramCache(cache_folder).load(key_of(device));
  if (!text) return std::nullopt;
  Tuning tuning;
  WorkShape& s = tuning.shape;
  std::istringstream stream(*text);
  stream >> s.brick_items >> s.scan_items >> s.scan_run >> s.fold_items >> s.reduce_items >>
      tuning.stages >> tuning.seconds >> tuning.tbb_seconds;
  return stream ? std::optional(tuning) : std::nullopt;
}

void store_tuning(int device, const std::string& cache_folder, const Tuning& tuning) {
  const WorkShape& s = tuning.shape;
  std::ostringstream stream;
  stream << s.brick_items << ' ' << s.scan_items << ' ' << s.scan_run << ' ' << s.fold_items << ' '
         << s.reduce_items << ' ' << tuning.stages << ' ' << tuning.seconds << ' '
         << tuning.tbb_seconds << '\n';
  ProgramCache(cache_folder).store(key_of(device), stream.str());
}

}  // namespace vasamesh
