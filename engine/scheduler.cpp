#include "scheduler.h"

#include <string>

#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::chrono::milliseconds kRest{10};  // between two words to the caller

}  // namespace

Scheduler::Scheduler(Context& context) : context_(context) {
  if (context.backends.empty())
    throw Error(ErrorCode::usage, "the context has no backend: make it with make_context()");
  for (const auto& backend : context.backends) backend->set_checkpoint([this] { checkpoint(); });
}

Scheduler::~Scheduler() {
  for (const auto& backend : context_.backends) backend->set_checkpoint({});
}

Backend& Scheduler::backend_for(Stage stage) {
  for (const auto& backend : context_.backends)
    if (backend->offers(stage) && (!host_alone_ || backend.get() == &host())) return *backend;
  throw Error(ErrorCode::internal, "no backend of the context offers a stage");
}

void Scheduler::fall_back(const DeviceFailure& failure) {
  host_alone_ = true;
  running_ = nullptr;
  end();
  if (!reports_.empty()) reports_.back().failure = failure.what();
}

void Scheduler::checkpoint() {
  if (Clock::now() - told_ >= kRest) progress(std::string(phase_), fraction_);
}

void Scheduler::progress(std::string_view phase, double fraction) {
  phase_ = phase;
  fraction_ = fraction;
  told_ = Clock::now();
  const bool asked = context_.cancel && context_.cancel->load(std::memory_order_relaxed);
  if (asked || (context_.progress && !context_.progress(phase, fraction)))
    throw Error(ErrorCode::cancelled, "cancelled during " + phase_);
}

void Scheduler::begin(const char* name, Stage stage) {
  end();
  Backend& backend = backend_for(stage);
  if (running_ && running_ != &backend) running_->settle();
  running_ = &backend;
  StageReport& report = reports_.emplace_back();
  report.name = name;
  report.backend = backend.name();
  report.device = backend.device();
  progress(name, 0);
  started_ = Clock::now();
  open_ = true;
}

void Scheduler::end() {
  if (!open_) return;
  open_ = false;
  StageReport& report = reports_.back();
  report.seconds = std::chrono::duration<double>(Clock::now() - started_).count();
  for (const auto& backend : context_.backends)
    report.bytes_held += static_cast<std::int64_t>(backend->bytes_held());
  progress(report.name, 1);
}

}  // namespace vasamesh
