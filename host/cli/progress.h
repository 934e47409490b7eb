#pragma once

/// \file
/// A bar on stderr with the name of the stage that runs. On a terminal only.

#include <chrono>
#include <string>
#include <string_view>

namespace vasamesh::cli {

class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// \param fraction  of the phase that is finished, 0 to 1.
  void show(std::string_view phase, double fraction);

  /// Removes the bar, so that other output can follow.
  void clear();

 private:
  const bool enabled_;
  bool shown_ = false;
  std::string phase_;
  std::chrono::steady_clock::time_point drawn_;
};

/// One line of the bar, e.g. "[#####.....]  52 %  poisson".
std::string progress_line(std::string_view phase, double fraction);

}  // namespace vasamesh::cli
