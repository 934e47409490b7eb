#include "picture/display.h"

#include <X11/Xlib.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <string>

#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

bool display_answers() {
  Display* display = XOpenDisplay(nullptr);
  if (display) XCloseDisplay(display);
  return display != nullptr;
}

/// Becomes a server that takes the first free number, and writes it to `ready` once it accepts
/// clients.
[[noreturn]] void become_server(int ready) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // never outlives the picture
  const std::string descriptor = std::to_string(ready);
  if (const int null = open("/dev/null", O_RDWR); null >= 0) dup2(null, STDERR_FILENO);
  execlp("Xvfb", "Xvfb", "-displayfd", descriptor.c_str(), "-screen", "0", "640x480x24",
         "-nolisten", "tcp", static_cast<char*>(nullptr));
  _exit(127);
}

/// What `descriptor` holds up to its first line's end, or to its own.
std::string read_line(int descriptor) {
  std::string line;
  for (char letter = 0; read(descriptor, &letter, 1) == 1 && letter != '\n';) line += letter;
  return line;
}

}  // namespace

OwnDisplay::OwnDisplay() {
  if (display_answers()) return;
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0)
    throw Error(ErrorCode::no_device, "DISPLAY: no X display, and no pipe to start Xvfb with");
  server_ = fork();
  if (server_ == 0) {
    close(ends[0]);
    become_server(ends[1]);
  }
  close(ends[1]);
  const std::string number = read_line(ends[0]);
  close(ends[0]);
  if (server_ < 0 || number.empty()) {
    if (server_ > 0) waitpid(server_, nullptr, 0);
    throw Error(ErrorCode::no_device,
                "DISPLAY: no X display, and Xvfb gave none; install xvfb and libgl1-mesa-dri");
  }
  setenv("DISPLAY", (":" + number).c_str(), 1);
}

OwnDisplay::~OwnDisplay() {
  if (server_ < 0) return;
  kill(server_, SIGTERM);
  waitpid(server_, nullptr, 0);
}

}  // namespace vasamesh
