#pragma once

/// \file
/// Who runs what: places each stage on a backend, keeps the time and the bytes of each, tells the
/// caller how far the work is and stops it on request.

#include <chrono>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "backend/backend.h"
#include "backend/device_failure.h"
#include "vasamesh/pipeline.h"
#include "vasamesh/report.h"

namespace vasamesh {

class Scheduler {
 public:
  /// \pre the context's last backend offers every stage.
  /// \throws Error usage, when the context has no backend.
  explicit Scheduler(Context& context);

  /// The backend that holds the shared buffers and runs what no other offers.
  Backend& host() { return *context_.backends.back(); }

  /// The first of the context's backends that offers the stage and has not failed.
  Backend& backend_for(Stage stage);

  /// work(backend) on the stage's backend. Where that fails as a device, it gets no more work of
  /// this conversion, the report says so, and the work is done again on the next backend.
  /// \pre until it succeeds, `work` changes nothing that it reads.
  template <class Work>
  auto run_on(Stage stage, const Work& work) {
    while (true) {
      Backend& backend = backend_for(stage);
      try {
        return work(backend);
      } catch (const DeviceFailure& failure) {
        give_up(backend, failure);
      }
    }
  }

  /// Tells the caller how far a phase is. \throws Error cancelled, when the caller wants to stop.
  void progress(std::string_view phase, double fraction);

  /// Begins a stage (ending the one before): its name for the report and for progress.
  void begin(const char* name, Stage stage);
  void end();

  std::vector<StageReport> take_reports() { return std::move(reports_); }

 private:
  /// Notes the failure in the open stage's report. \throws the failure, when it is the last
  /// backend's.
  void give_up(const Backend& backend, const DeviceFailure& failure);

  Context& context_;
  std::vector<const Backend*> failed_;
  std::vector<StageReport> reports_;
  std::chrono::steady_clock::time_point started_;
  bool open_ = false;
};

}  // namespace vasamesh
