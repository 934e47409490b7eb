#include "cli/progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>

namespace vasamesh::cli {

namespace {

constexpr int kCells = 30;
constexpr std::chrono::milliseconds kRedraw{50};

}  // namespace

Progress::Progress(bool quiet) : enabled_(!quiet && isatty(STDERR_FILENO) == 1) {}

void Progress::show(std::string_view phase, double fraction) {
  if (!enabled_) return;
  const auto now = std::chrono::steady_clock::now();
  if (shown_ && phase == phase_ && now - drawn_ < kRedraw) return;
  drawn_ = now;
  phase_ = phase;
  shown_ = true;
  fmt::print(stderr, "\r\033[K{}", progress_line(phase, fraction));
  std::fflush(stderr);
}

void Progress::clear() {
  if (!shown_) return;
  shown_ = false;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
}

std::string progress_line(std::string_view phase, double fraction) {
  const double part = std::clamp(fraction, 0.0, 1.0);
  const int full = static_cast<int>(part * kCells);
  return fmt::format("[{:#<{}}{:.<{}}] {:3.0f} %  {}", "", full, "", kCells - full, 100 * part,
                     phase);
}

}  // namespace vasamesh::cli
