#include "cli/interrupt.h"

#include <signal.h>
#include <unistd.h>

#include <csignal>

#include "vasamesh/errors.h"

namespace vasamesh::cli {

namespace {

std::atomic<bool> asked{false};
std::atomic<bool> ask_first{true};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void on_signal(int) {
  if (asked.exchange(true) || !ask_first) _exit(static_cast<int>(ErrorCode::cancelled));
}

/// As nohup has SIGHUP, and a shell SIGINT for what runs in the background of a script.
bool is_ignored(int signal) {
  struct sigaction action = {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

}  // namespace

void catch_interrupts(bool ask) {
  ask_first = ask;
  struct sigaction action = {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (!is_ignored(signal)) sigaction(signal, &action, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);
}

const std::atomic<bool>& interrupted() { return asked; }

void stop_if_interrupted() {
  if (asked) throw Error(ErrorCode::cancelled, "interrupted: nothing was written");
}

}  // namespace vasamesh::cli
