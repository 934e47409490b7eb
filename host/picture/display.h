#pragma once

/// \file
/// The X display to render with. Alone in its file: Xlib's header defines macros.

#include <sys/types.h>

namespace vasamesh {

/// An X display for as long as it lives: the one that DISPLAY names if that answers, and otherwise
/// an Xvfb of its own, to which DISPLAY is set. That server has gone when the destructor returns,
/// so that displays opened one after another do not meet (xvfb-run does not wait for its end).
class OwnDisplay {
 public:
  /// \throws Error (no_device) where neither is to be had
  OwnDisplay();
  ~OwnDisplay();
  OwnDisplay(const OwnDisplay&) = delete;
  OwnDisplay& operator=(const OwnDisplay&) = delete;

 private:
  pid_t server_ = -1;  ///< -1 where a display was there
};

}  // namespace vasamesh
