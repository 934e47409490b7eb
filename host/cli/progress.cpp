#include "cli/progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace vasamesh::cli {

namespace {

constexpr int kCells = 30;
constexpr std::chrono::milliseconds kRedraw{50};

/// fmt would throw where the terminal is gone.
void draw(const std::string& line) {
  std::fprintf(stderr, "\r\033[K%s", line.c_str());
  std::fflush(stderr);
}

}  // namespace

Progress::Progress(bool quiet) : enabled_(!quiet && isatty(STDERR_FILENO) == 1) {}

void Progress::show(std::string_view phase, double fraction) {
  if (!enabled_) return;
  const auto now = std::chrono::steady_clock::now();
  if (shown_ && phase == phase_ && now - drawn_ < kRedraw) return;
  drawn_ = now;
  phase_ = phase;
  shown_ = true;
  draw(progress_line(phase, fraction));
}

void Progress::clear() {
  if (!shown_) return;
  shown_ = false;
  draw("");
}

std::string progress_line(std::string_view phase, double fraction) {
  const double part = std::clamp(fraction, 0.0, 1.0);
  const int full = static_cast<int>(part * kCells);
  return fmt::format("[{:#<{}}{:.<{}}] {:3.0f} %  {}", "", full, "", kCells - full, 100 * part,
                     phase);
}

}  // namespace vasamesh::cli
