#pragma once

/// \file
/// The public entry: a segmentation in, a proven closed surface and a report out.
///
///     Context context = make_context({});             // host/include/vasamesh/host.h
///     Result result = convert(volume, Parameters{}, context);

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "vasamesh/errors.h"
#include "vasamesh/parameters.h"
#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh {

class Backend;

/// What a conversion runs on and whom it tells. Backends are shared: one Context may serve many
/// conversions, one at a time.
struct Context {
  /// The backends in order of preference; a stage runs on the first that offers it. The last one
  /// must offer every stage (make_context puts the oneTBB backend there). None is null.
  std::vector<std::shared_ptr<Backend>> backends;

  /// Called with the phase's name and its finished fraction, 0 to 1, from the thread that called
  /// convert(): when a phase gets on, and every ten milliseconds or so in between. False cancels:
  /// convert() throws within 100 ms. May be empty. (While other work fills a task_arena of the
  /// caller's, that thread may have to wait for it, and says nothing; `cancel` is heeded.)
  std::function<bool(std::string_view phase, double fraction)> progress;

  /// Set it from any thread, or from a signal handler, to cancel. May be null.
  const std::atomic<bool>* cancel = nullptr;

  /// For the report: why no device takes part, where one might have. Set by make_context().
  std::string host_reason;
};

/// A surface and what is known about it.
struct Result {
  TriangleMesh mesh;
  Report report;
};

/// Converts one segmentation. The surface has passed its proof, in float32 and in the space that
/// was asked for: closed, manifold, outward, without self-intersection, of the segmentation's
/// topology.
///
/// \throws Error usage (a parameter out of its range, a context without backends), bad_input
///         (nothing in the foreground, an unusable geometry, an origin too far out for float32),
///         failed_check (a surface that could not be proven), refused (more memory than allowed or
///         there is, more elements than 32 bits number), cancelled. What the context's `progress`
///         throws comes through.
Result convert(const VolumeView& volume, const Parameters& parameters, Context& context);

/// As convert(), for many volumes: keeps its buffers from one call to the next. One that was moved
/// from can only be assigned to or destroyed.
class Converter {
 public:
  explicit Converter(Context context);
  ~Converter();
  Converter(Converter&&) noexcept;
  Converter& operator=(Converter&&) noexcept;

  /// As vasamesh::convert(), errors too; any number of times, also after an error.
  Result convert(const VolumeView& volume, const Parameters& parameters);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vasamesh
