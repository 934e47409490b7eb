#include "tune.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "backend/backend.h"
#include "opencl/backend.h"
#include "opencl/tuning.h"
#include "stages/distance.h"
#include "tbb/backend.h"
#include "vasamesh/errors.h"
#include "vasamesh/pipeline.h"

namespace vasamesh {

namespace {

constexpr int kSide = 128, kRepeats = 3;
constexpr double kFaster = 0.9;         // of oneTBB's time: what counts as less
constexpr float kRing = 44, kTube = 7;  // radii of the torus, voxels

// What counts as near, in voxels.
constexpr double kLargestDistance = 0.25, kMeanDistance = 0.05;

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

std::string words(const WorkShape& shape) {
  return std::to_string(shape.brick_items) + " items a brick, groups of " +
         std::to_string(shape.fold_items);
}

/// A processor with some threads, by name.
std::string name_of(const Backend& host) { return processor_name() + ", " + host.device(); }

/// Of the torus, whose voxels are 1 mm.
bool are_near(Backend& backend, const TriangleMesh& a, const TriangleMesh& b) {
  const DistanceReport distance = measure_distance(backend, a, b, 1);
  const auto is_small = [](const OneWayDistance& way) {
    return way.maximum <= kLargestDistance && way.mean <= kMeanDistance;
  };
  return is_small(distance.to) && is_small(distance.back);
}

/// A device against oneTBB on one volume.
class Tuner {
 public:
  Tuner(const DeviceInfo& device, std::shared_ptr<Backend> host, const std::atomic<bool>* cancel)
      : device_(device.opencl_index), host_(std::move(host)), cancel_(cancel), voxels_(torus()) {
    view_.data = voxels_.data();
    view_.geometry.size = {kSide, kSide, kSide};
  }

  /// Taken where it is the fastest so far.
  TuneTrial attempt(const WorkShape& shape, const std::string& name) {
    OpenClOptions options;
    options.device = device_;
    options.work_shape = shape;
    options.any_arithmetic = true;
    options.workers = host_;
    options.cancel = cancel_;
    TuneTrial trial;
    trial.shape = name;
    try {
      const std::shared_ptr<Backend> opened = make_opencl_backend(options);
      if (tbb_.stages.empty()) tbb_ = timed({host_});  // not for a device that cannot be opened
      const Timed time = timed({opened, host_});
      trial.seconds = time.seconds;
      trial.agrees = opened->other_arithmetic().empty() ? time.mesh == tbb_.mesh
                                                        : are_near(*host_, time.mesh, tbb_.mesh);
      if (trial.agrees && (!is_found() || time.seconds < best_.seconds))
        take(trial, time, shape, *opened);
    } catch (const Error& error) {
      if (error.code() == ErrorCode::cancelled) throw;
      trial.failure = error.what();
    }
    return trial;
  }

  bool is_found() const { return !best_.shape.empty(); }
  const TuneTrial& best() const { return best_; }
  const WorkShape& shape() const { return shape_; }
  double tbb_seconds() const { return tbb_.seconds; }
  const std::string& other_arithmetic() const { return other_arithmetic_; }

  /// In which the best shape beats oneTBB, bit_of each.
  std::uint32_t stages() const { return stages_; }

  std::string stage_names() const {
    std::string names;
    for (const auto& [name, stage] : kStages)
      if (stages_ & bit_of(stage)) names += (names.empty() ? "" : ", ") + name;
    return names;
  }

 private:
  /// The best of the repeats, stage by stage and in all.
  struct Timed {
    double seconds = std::numeric_limits<double>::infinity();
    std::map<Stage, double> stages;
    TriangleMesh mesh;
  };

  Timed timed(std::vector<std::shared_ptr<Backend>> backends) const;

  void take(const TuneTrial& trial, const Timed& time, const WorkShape& shape,
            const Backend& opened) {
    best_ = trial;
    shape_ = shape;
    other_arithmetic_ = opened.other_arithmetic();
    stages_ = 0;
    for (const auto& [stage, seconds] : time.stages)
      if (opened.offers(stage) && seconds < kFaster * tbb_.stages.at(stage))
        stages_ |= bit_of(stage);
  }

  int device_;
  std::shared_ptr<Backend> host_;
  const std::atomic<bool>* cancel_;
  std::vector<std::uint8_t> voxels_;
  VolumeView view_;
  Timed tbb_;
  TuneTrial best_;
  std::string other_arithmetic_;
  WorkShape shape_ = kWorkGroupShape;
  std::uint32_t stages_ = 0;
};

/// \throws Error no_device, where the device fails.
Tuner::Timed Tuner::timed(std::vector<std::shared_ptr<Backend>> backends) const {
  Context context;
  context.backends = std::move(backends);
  context.cancel = cancel_;
  Timed best;
  for (int repeat = 0; repeat <= kRepeats; ++repeat) {
    Result result = convert(view_, {}, context);
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

/// \param tuner  which has found the device's best shape.
DeviceWorth worth_in(const Tuner& tuner, const DeviceInfo& device) {
  if (!tuner.other_arithmetic().empty())
    return {0, device.name + " " + tuner.other_arithmetic() +
                   ", so that its bytes may not be the processor's: name it to use it"};
  if (!tuner.stages()) return {0, device.name + " was not faster than the processor in any stage"};
  return {tuner.stages(), ""};
}

/// What the trial of a device in the shape that it has comes to.
DeviceWorth tried(const DeviceInfo& device, const std::shared_ptr<Backend>& host,
                  const std::atomic<bool>* cancel) {
  const int index = device.opencl_index;
  try {
    Tuner tuner(device, host, cancel);
    const TuneTrial trial =
        tuner.attempt(load_shape(index, {}).value_or(usual_opencl_shape(index)), "usual");
    if (!trial.failure.empty()) return {0, device.name + " failed in its trial: " + trial.failure};
    if (!trial.agrees) return {0, device.name + " gave another surface than the processor"};
    return worth_in(tuner, device);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::cancelled) throw;
    return {0, device.name + " failed in its trial: " + error.what()};
  }
}

}  // namespace

TuneResult tune_device(const DeviceInfo& device, int threads,
                       const std::function<void(const TuneTrial&)>& tell) {
  const int index = device.opencl_index;
  const std::shared_ptr<Backend> host = make_tbb_backend(threads, nullptr);
  Tuner tuner(device, host, nullptr);
  std::string failure = "other surfaces";
  const auto attempt = [&](const WorkShape& shape, const std::string& name) {
    const TuneTrial trial = tuner.attempt(shape, name);
    if (!trial.failure.empty()) failure = trial.failure;
    if (tell) tell(trial);
  };
  const WorkShape usual = usual_opencl_shape(index);
  attempt(usual, "usual");
  for (const WorkShape& shape : shapes_to_try())
    if (shape != usual) attempt(shape, words(shape));
  if (!tuner.is_found())
    throw Error(ErrorCode::no_device, device.name + " gives other surfaces than oneTBB, or none (" +
                                          failure + "): use --backend tbb");
  const bool is_kept = store_shape(index, {}, tuner.shape()) &&
                       store_worth(index, {}, name_of(*host), worth_in(tuner, device));
  return {tuner.best(), tuner.tbb_seconds(), tuner.stage_names(), tuner.other_arithmetic(),
          is_kept};
}

DeviceWorth worth_of(const DeviceInfo& device, const std::shared_ptr<Backend>& host,
                     const std::atomic<bool>* cancel) {
  const int index = device.opencl_index;
  const std::string beside = name_of(*host);
  if (const auto known = load_worth(index, {}, beside)) return *known;
  // First of all, so that a driver that takes the program down does so once.
  if (!store_worth(
          index, {}, beside,
          {0, device.name + " was not tried to the end, or is being tried: try it with vasamesh "
                            "tune, or name the device"}))
    return {0, device.name +
                   " was not tried, since the cache folder cannot be written: make it one that "
                   "can, or name the device"};
  try {
    const DeviceWorth worth = tried(device, host, cancel);
    store_worth(index, {}, beside, worth);
    return worth;
  } catch (const Error&) {
    forget_worth(index, {}, beside);
    throw;
  }
}

}  // namespace vasamesh
