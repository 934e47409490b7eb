#include "tune.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "backend/backend.h"
#include "opencl/backend.h"
#include "tbb/backend.h"
#include "vasamesh/errors.h"
#include "vasamesh/pipeline.h"

namespace vasamesh {

namespace {

constexpr int kSide = 128, kRepeats = 3;
constexpr float kRing = 44, kTube = 7;  // radii of the torus, voxels

/// A torus, its axis along z.
std::vector<std::uint8_t> torus() {
  std::vector<std::uint8_t> voxels(std::size_t{kSide} * kSide * kSide);
  std::size_t at = 0;
  for (int z = 0; z < kSide; ++z)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto u = static_cast<float>(x - kSide / 2), v = static_cast<float>(y - kSide / 2),
                   w = static_cast<float>(z - kSide / 2), ring = std::sqrt(u * u + v * v) - kRing;
        voxels[at++] = ring * ring + w * w < kTube * kTube;
      }
  return voxels;
}

/// Which stage of the contract a stage of the report is, for those that a device may take.
const std::map<std::string, Stage> kStages = {
    {"input", Stage::points},    {"points", Stage::points},   {"normals", Stage::normals},
    {"octree", Stage::octree},   {"poisson", Stage::poisson}, {"topology", Stage::lattice},
    {"surface", Stage::surface}, {"sizes", Stage::sizing},    {"expand", Stage::expand},
    {"stitch", Stage::stitch},   {"remesh", Stage::relax},    {"finish", Stage::relax},
    {"check", Stage::verify}};

/// The best of the repeats, stage by stage and in all.
struct Timed {
  double seconds = std::numeric_limits<double>::infinity();
  std::map<Stage, double> stages;
  TriangleMesh mesh;
};

Timed timed(const VolumeView& volume, Context& context) {
  Timed best;
  for (int repeat = 0; repeat <= kRepeats; ++repeat) {
    Result result = convert(volume, {}, context);
    double seconds = 0;
    std::map<Stage, double> stages;
    for (const StageReport& stage : result.report.stages) {
      if (!stage.failure.empty()) throw Error(ErrorCode::no_device, stage.failure);
      seconds += stage.seconds;
      const auto known = kStages.find(stage.name);
      if (known != kStages.end()) stages[known->second] += stage.seconds;
    }
    best.mesh = std::move(result.mesh);
    if (repeat == 0 || seconds >= best.seconds) continue;
    best.seconds = seconds;
    best.stages = stages;
  }
  return best;
}

std::string words(const WorkShape& shape) {
  return std::to_string(shape.brick_items) + " items a brick, groups of " +
         std::to_string(shape.fold_items);
}

/// A device against oneTBB on one volume.
class Tuner {
 public:
  Tuner(const DeviceInfo& device, int threads)
      : device_(device.number - 1), host_(make_tbb_backend(threads, nullptr)), voxels_(torus()) {
    OpenClOptions options;
    options.device = device_;
    make_opencl_backend(options);  // one that cannot be opened costs no more
    view_.data = voxels_.data();
    view_.geometry.size = {kSide, kSide, kSide};
    Context context;
    context.backends = {host_};
    tbb_ = timed(view_, context);
  }

  /// With the device's usual shape where none is given; taken where it is the fastest so far.
  TuneTrial attempt(const std::optional<WorkShape>& shape) {
    OpenClOptions options;
    options.device = device_;
    options.work_shape = shape;
    options.workers = host_;
    Context context;
    context.backends = {make_opencl_backend(options), host_};
    const Timed time = timed(view_, context);
    TuneTrial trial{
        shape ? words(*shape) : "usual", time.seconds,
        time.mesh.vertices == tbb_.mesh.vertices && time.mesh.triangles == tbb_.mesh.triangles};
    if (trial.agrees && (result_.best.shape.empty() || time.seconds < result_.best.seconds))
      take(trial, time, shape.value_or(usual_opencl_shape(device_)));
    return trial;
  }

  TuneResult finish() const {
    if (result_.best.shape.empty())
      throw Error(ErrorCode::no_device,
                  "the device gives other surfaces than oneTBB: use --backend tbb");
    store_tuning(device_, {}, tuning_);
    return result_;
  }

 private:
  void take(const TuneTrial& trial, const Timed& time, const WorkShape& shape) {
    tuning_ = {shape, 0, time.seconds, tbb_.seconds};
    result_ = {trial, tbb_.seconds, {}};
    for (const auto& [stage, seconds] : time.stages)
      if (seconds < tbb_.stages.at(stage)) tuning_.stages |= bit_of(stage);
    for (const auto& [name, stage] : kStages)
      if (tuning_.stages & bit_of(stage))
        result_.stages += (result_.stages.empty() ? "" : ", ") + name;
  }

  int device_;
  std::shared_ptr<Backend> host_;
  std::vector<std::uint8_t> voxels_;
  VolumeView view_;
  Timed tbb_;
  Tuning tuning_;
  TuneResult result_;
};

}  // namespace

TuneResult tune_device(const DeviceInfo& device, int threads, bool search,
                       const std::function<void(const TuneTrial&)>& tell) {
  Tuner tuner(device, threads);
  const auto attempt = [&](const std::optional<WorkShape>& shape) {
    const TuneTrial trial = tuner.attempt(shape);
    if (tell) tell(trial);
  };
  attempt({});
  if (search)
    for (const WorkShape& shape : shapes_to_try()) attempt(shape);
  return tuner.finish();
}

std::uint32_t stages_worth(const DeviceInfo& device, int threads) {
  const int number = device.number - 1;
  try {
    if (const std::optional<Tuning> tuning = load_tuning(number, {})) return tuning->stages;
    try {
      tune_device(device, threads, false, {});
    } catch (const Error&) {
      Tuning failed;
      failed.shape = usual_opencl_shape(number);
      store_tuning(number, {}, failed);
    }
    const std::optional<Tuning> tuning = load_tuning(number, {});
    return tuning ? tuning->stages : 0;
  } catch (const Error&) {
    return 0;
  }
}

}  // namespace vasamesh
