#include "picture/display.h"

#include <X11/Xlib.h>

namespace vasamesh {

bool has_display() {
  Display* display = XOpenDisplay(nullptr);
  if (display) XCloseDisplay(display);
  return display != nullptr;
}

}  // namespace vasamesh
