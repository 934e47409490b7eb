#include "opencl/tuning.h"

#include <sstream>

#include "opencl/opencl_backend.h"
#include "opencl/program_cache.h"

namespace vasamesh {

namespace {

/// Everything that `what` was found to be depends on.
std::string key_of(int number, const std::string& what) {
  const cl::Device device = opencl_devices().at(static_cast<std::size_t>(number));
  std::string key = what + "\n" + ask<CL_DEVICE_NAME>(device) + "\n" +
                    ask<CL_DRIVER_VERSION>(device) + "\n" + ask<CL_DEVICE_VERSION>(device) + "\n";
  for (const KernelSource& source : kernel_sources()) key += source.text;
  return key;
}

std::string shape_key(int device) { return key_of(device, "shape 1"); }
std::string worth_key(int device, const std::string& host) {
  return key_of(device, "worth 1 beside " + host);
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

std::optional<WorkShape> load_shape(int device, const std::string& cache_folder) {
  const std::optional<std::string> text = ProgramCache(cache_folder).load(shape_key(device));
  if (!text) return std::nullopt;
  std::istringstream stream(*text);
  WorkShape s{};
  stream >> s.brick_items >> s.scan_items >> s.scan_run >> s.fold_items >> s.reduce_items;
  return stream ? std::optional(s) : std::nullopt;
}

bool store_shape(int device, const std::string& cache_folder, const WorkShape& s) {
  std::ostringstream stream;
  stream << s.brick_items << ' ' << s.scan_items << ' ' << s.scan_run << ' ' << s.fold_items << ' '
         << s.reduce_items << '\n';
  return ProgramCache(cache_folder).store(shape_key(device), stream.str());
}

std::optional<DeviceWorth> load_worth(int device, const std::string& cache_folder,
                                      const std::string& host) {
  const std::optional<std::string> text = ProgramCache(cache_folder).load(worth_key(device, host));
  if (!text) return std::nullopt;
  std::istringstream stream(*text);
  DeviceWorth worth;
  stream >> worth.stages >> std::ws;
  if (!stream) return std::nullopt;
  std::getline(stream, worth.reason);
  return worth;
}

bool store_worth(int device, const std::string& cache_folder, const std::string& host,
                 const DeviceWorth& worth) {
  return ProgramCache(cache_folder)
      .store(worth_key(device, host), std::to_string(worth.stages) + "\n" + worth.reason + "\n");
}

void forget_worth(int device, const std::string& cache_folder, const std::string& host) {
  ProgramCache(cache_folder).remove(worth_key(device, host));
}

}  // namespace vasamesh
