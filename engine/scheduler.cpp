#include "scheduler.h"

#include <string>

#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::chrono::milliseconds kRest{10};  // between two words to the caller

void tell_backend(const Backend& backend, StageReport& report) {
  report.backend = backend.name();
  report.device = backend.device();
  report.other_arithmetic = backend.other_arithmetic();
}

}  // namespace

Scheduler::Scheduler(Context& context, std::size_t max_memory)
    : context_(context), max_memory_(max_memory) {
  if (context.backends.empty())
    throw Error(ErrorCode::usage, "the context has no backend: make it with make_context()");
  for (const auto& backend : context.backends)
    if (!backend)
      throw Error(ErrorCode::usage,
                  "a backend of the context is null: make it with make_context()");
  for (const auto& backend : context.backends) {
    backend->set_byte_limit(max_memory);
    backend->set_checkpoint([this] { checkpoint(); });
  }
}

Scheduler::~Scheduler() {
  for (const auto& backend : context_.backends) backend->set_checkpoint({});
}

Backend& Scheduler::backend_for(Stage stage) {
  for (const auto& backend : context_.backends)
    if (backend->offers(stage) && (!host_alone_ || backend.get() == &host())) return *backend;
  throw Error(ErrorCode::internal, "no backend of the context offers a stage");
}

void Scheduler::check_memory(const BytePlan& plan) {
  if (max_memory_ && plan.least > max_memory_)
    throw Error(ErrorCode::refused,
                "the conversion needs " + std::to_string(plan.least) + " to " +
                    std::to_string(plan.most) + " bytes, and --max-memory allows " +
                    std::to_string(max_memory_) + ": allow more, or convert a part of the volume");
  if (host_alone_) return;
  for (const auto& backend : context_.backends)
    if (backend->memory() && backend->memory() < plan.most)
      throw DeviceFailure(ErrorCode::refused,
                          backend->device() + " has " + std::to_string(backend->memory()) +
                              " bytes, and the conversion may need " + std::to_string(plan.most));
}

void Scheduler::fall_back(const DeviceFailure& failure) {
  host_alone_ = true;
  if (open_) close();
  running_ = nullptr;
  if (!reports_.empty()) reports_.back().failure = failure.what();
}

/// In a task arena of the caller's that is busy, the thread that is told may wait while others do
/// its work: these stop it too.
void Scheduler::checkpoint() {
  if (std::this_thread::get_id() != thread_) {
    if (is_cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
  } else if (Clock::now() - told_ >= kRest) {
    tell();
  }
}

void Scheduler::progress(std::string_view phase, double fraction) {
  phase_ = phase;
  fraction_ = fraction;
  tell();
}

void Scheduler::tell() {
  told_ = Clock::now();
  if (is_cancelled() || (context_.progress && !context_.progress(phase_, fraction_)))
    throw Error(ErrorCode::cancelled, "cancelled during " + phase_);
}

std::string Scheduler::host_reason(Stage stage, const char* on_host) {
  if (host_alone_ || &backend_for(stage) != &host()) return {};
  const bool has_device = context_.backends.size() > 1;
  if (!has_device && context_.host_reason.empty()) return {};
  if (stage == Stage::mesh) return on_host;
  if (stage == Stage::verify && !context_.backends.front()->other_arithmetic().empty())
    return "the device's arithmetic is not the one that proofs rest on";
  return has_device ? "the device has been given other stages alone" : context_.host_reason;
}

void Scheduler::begin(const char* name, Stage stage, const char* on_host) {
  end();
  Backend& backend = backend_for(stage);
  if (running_ && running_ != &backend) running_->settle();
  running_ = &backend;
  StageReport& report = reports_.emplace_back();
  report.name = name;
  tell_backend(backend, report);
  report.host_reason = host_reason(stage, on_host);
  if (&backend != &host()) report.host_part = on_host;
  traffic_ = backend.traffic();
  progress(name, 0);
  started_ = Clock::now();
  open_ = true;
}

void Scheduler::end() {
  if (!open_) return;
  running_->finish();
  close();
  progress(reports_.back().name, 1);
}

void Scheduler::close() {
  open_ = false;
  StageReport& report = reports_.back();
  const Traffic traffic = running_->traffic();
  report.launches = traffic.launches - traffic_.launches;
  report.copies = traffic.copies - traffic_.copies;
  report.bytes_copied = traffic.bytes - traffic_.bytes;
  report.device_seconds = traffic.waited - traffic_.waited;
  if (running_ != &host() && !host_alone_ && report.launches == 0) {
    tell_backend(host(), report);
    report.host_reason = "nothing in it was for the device";
    report.host_part.clear();
  }
  report.seconds = std::chrono::duration<double>(Clock::now() - started_).count();
  for (const auto& backend : context_.backends)
    report.bytes_held += static_cast<std::int64_t>(backend->bytes_held());
}

}  // namespace vasamesh
