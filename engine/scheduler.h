#pragma once

/// \file
/// Who runs what: places each stage on a backend, keeps the time and the bytes of each, tells the
/// caller how far the work is and stops it on request.

#include <chrono>
#include <memory>
#include <string_view>
#include <vector>

#include "backend/backend.h"
#include "vasamesh/pipeline.h"
#include "vasamesh/report.h"

namespace vasamesh {

class Scheduler {
 public:
  /// \pre the context's last backend offers every stage.
  /// \throws Error usage, when the context has no backend.
  explicit Scheduler(Context& context);

  /// The backend that runs what no other offers.
  Backend& host() { return *context_.backends.back(); }

  /// The first of the context's backends that offers the stage.
  Backend& backend_for(Stage stage);

  /// Tells the caller how far a phase is. \throws Error cancelled, when the caller wants to stop.
  void progress(std::string_view phase, double fraction);

  /// Begins a stage (ending the one before): its name for the report and for progress.
  void begin(const char* name, Stage stage);
  void end();

  std::vector<StageReport> take_reports() { return std::move(reports_); }

 private:
  Context& context_;
  Backend* running_ = nullptr;  ///< the backend of the last stage begun
  std::vector<StageReport> reports_;
  std::chrono::steady_clock::time_point started_;
  bool open_ = false;
};

}  // namespace vasamesh
