#pragma once

/// \file
/// Whether there is an X display to render with. Alone in its file: Xlib's header defines macros.

namespace vasamesh {

/// Whether the display that DISPLAY names answers.
bool has_display();

}  // namespace vasamesh
