#pragma once

/// \file
/// Who runs what: places each stage on a backend, keeps the time and the bytes of each, tells the
/// caller how far the work is and stops it on request.

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "backend/backend.h"
#include "backend/device_failure.h"
#include "byte_plan.h"
#include "vasamesh/pipeline.h"
#include "vasamesh/report.h"

namespace vasamesh {

class Scheduler {
 public:
  /// \pre the context's last backend offers every stage.
  /// \param max_memory  bytes that all backends' buffers may hold together; 0: no limit.
  /// \throws Error usage, when the context has no backend.
  explicit Scheduler(Context& context, std::size_t max_memory = 0);
  ~Scheduler();
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  /// The backend that runs what no other offers.
  Backend& host() { return *context_.backends.back(); }

  /// The first of the context's backends that offers the stage; after fall_back(), the host's.
  Backend& backend_for(Stage stage);

  /// Before the work that needs most of the memory. \throws Error refused, when the limit is below
  /// the least that is planned; DeviceFailure, when a device has less than the most.
  void check_memory(const BytePlan& plan);

  /// Ends the stage that failed, with the failure in its report. From now on everything runs on the
  /// host's backend: the caller starts again from the input.
  void fall_back(const DeviceFailure& failure);

  /// Tells the caller how far a phase is; between two calls the backends' checkpoints tell it
  /// again, on the thread that made the scheduler. \throws Error cancelled, when the caller wants
  /// to stop.
  void progress(std::string_view phase, double fraction);

  /// Begins a stage (ending the one before): its name for the report and for progress.
  /// \param on_host  what of it the host does, whatever the backend; for Stage::mesh, which is the
  ///        host's, why.
  void begin(const char* name, Stage stage, const char* on_host = "");
  void end();

  std::vector<StageReport> take_reports() { return std::move(reports_); }

 private:
  using Clock = std::chrono::steady_clock;

  /// Called on any thread that works for the conversion.
  void checkpoint();

  /// Tells the caller, on the thread that is told. \throws Error cancelled
  void tell();
  bool is_cancelled() const {
    return context_.cancel && context_.cancel->load(std::memory_order_relaxed);
  }

  /// What the open stage has come to, into its report.
  void close();

  /// Why a stage runs on the host where there is a device; empty where there is none.
  std::string host_reason(Stage stage, const char* on_host);

  Context& context_;
  std::size_t max_memory_;
  Backend* running_ = nullptr;  ///< the backend of the last stage begun
  std::vector<StageReport> reports_;
  const std::thread::id thread_ = std::this_thread::get_id();  ///< the one that is told
  Clock::time_point started_, told_;
  std::string phase_;  ///< as told last, with its fraction
  double fraction_ = 0;
  Traffic traffic_;  ///< of the running backend when the stage began
  bool open_ = false;
  bool host_alone_ = false;
};

}  // namespace vasamesh
