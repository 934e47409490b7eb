#include "support/backends.h"

#include "tbb/backend.h"
#ifdef VASAMESH_WITH_OPENCL
#include "opencl/backend.h"
#endif

namespace vasamesh {

namespace {

#ifdef VASAMESH_WITH_OPENCL
constexpr WorkShape kSmallGroupShape{16, 128, 8, 32, 128};

std::shared_ptr<Backend> open_opencl(const WorkShape& shape, DeviceCopies copies) {
  if (list_opencl_devices().empty()) return nullptr;
  OpenClOptions options;
  options.work_shape = shape;
  options.copies = copies;
  options.workers = make_tbb_backend(2, nullptr);
  return make_opencl_backend(options);
}
#endif

}  // namespace

std::vector<std::string> backend_names() {
#ifdef VASAMESH_WITH_OPENCL
  return {"tbb", "opencl_one_item", "opencl_work_group"};
#else
  return {"tbb"};
#endif
}

std::shared_ptr<Backend> open_backend(const std::string& name) {
#ifdef VASAMESH_WITH_OPENCL
  if (name == "opencl_one_item") return open_opencl(kOneItemShape, DeviceCopies::shared);
  if (name == "opencl_work_group") return open_opencl(kWorkGroupShape, DeviceCopies::separate);
  if (name == "opencl_small_group") return open_opencl(kSmallGroupShape, DeviceCopies::shared);
#endif
  return make_tbb_backend(2, nullptr);
}

}  // namespace vasamesh
