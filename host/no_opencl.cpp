/// \file
/// A build without the OpenCL backend: it has no devices, and nothing can be asked of one.

#include "opencl/backend.h"
#include "opencl/speed.h"
#include "tune.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

[[noreturn]] void refuse() {
  throw Error(ErrorCode::no_device, "this build has no OpenCL backend: use --backend tbb");
}

}  // namespace

std::vector<DeviceInfo> list_opencl_devices() { return {}; }

std::string opencl_remedy() { return "take a build with the OpenCL backend"; }

std::shared_ptr<Backend> make_opencl_backend(const OpenClOptions&) { refuse(); }

DeviceSpeed measure_opencl_speed(int) { refuse(); }

TuneResult tune_device(const DeviceInfo&, int, const std::function<void(const TuneTrial&)>&) {
  refuse();
}

DeviceWorth worth_of(const DeviceInfo&, const std::shared_ptr<Backend>&, const std::atomic<bool>*) {
  refuse();
}

}  // namespace vasamesh
