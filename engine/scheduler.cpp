#include "scheduler.h"

#include <string>

#include "vasamesh/errors.h"

namespace vasamesh {

Scheduler::Scheduler(Context& context) : context_(context) {
  if (context.backends.empty())
    throw Error(ErrorCode::usage, "the context has no backend: make it with make_context()");
}

Backend& Scheduler::backend_for(Stage stage) {
  for (const auto& backend : context_.backends)
    if (backend->offers(stage)) return *backend;
  throw Error(ErrorCode::internal, "no backend of the context offers a stage");
}

void Scheduler::progress(std::string_view phase, double fraction) {
  const bool asked = context_.cancel && context_.cancel->load(std::memory_order_relaxed);
  if (asked || (context_.progress && !context_.progress(phase, fraction)))
    throw Error(ErrorCode::cancelled, "cancelled during " + std::string(phase));
}

void Scheduler::begin(const char* name, Stage stage) {
  end();
  Backend& backend = backend_for(stage);
  if (running_ && running_ != &backend) running_->settle();
  running_ = &backend;
  reports_.push_back({name, backend.name(), backend.device(), 0, 0});
  progress(name, 0);
  started_ = std::chrono::steady_clock::now();
  open_ = true;
}

void Scheduler::end() {
  if (!open_) return;
  open_ = false;
  StageReport& report = reports_.back();
  report.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count();
  for (const auto& backend : context_.backends)
    report.bytes_held += static_cast<std::int64_t>(backend->bytes_held());
  progress(report.name, 1);
}

}  // namespace vasamesh
