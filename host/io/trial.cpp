#include "io/trial.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <iterator>
#include <limits>
#include <new>
#include <string>

#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

// A library, or a sanitizer, may end the copy by itself, with 0 or 1.
enum ExitStatus { kReturned = 90, kThrewError = 91, kThrewOther = 92, kNoMemory = 93 };

constexpr int kInterrupts[] = {SIGINT, SIGTERM, SIGHUP};

std::int64_t address_space() {
  long pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return static_cast<std::int64_t>(pages) * sysconf(_SC_PAGESIZE);
}

void limit_process(std::int64_t most_bytes) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  rlimit memory{};
  getrlimit(RLIMIT_AS, &memory);
  memory.rlim_cur = std::min(memory.rlim_cur, static_cast<rlim_t>(address_space() + most_bytes));
  setrlimit(RLIMIT_AS, &memory);
  const rlim_t seconds = 60 + static_cast<rlim_t>(most_bytes >> 27);
  const rlimit processor{seconds, seconds + 1};
  setrlimit(RLIMIT_CPU, &processor);
}

/// Faults and interrupts end the copy, which does not outlive the program.
void leave_signals() {
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGXCPU})
    std::signal(signal, SIG_DFL);
  for (const int signal : kInterrupts) {
    struct sigaction action = {};
    if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler != SIG_IGN)
      std::signal(signal, SIG_DFL);
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
}

void silence() {
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
}

/// The copy's part: the message of an Error goes into the pipe, after a byte of its code.
[[noreturn]] void run_trial(int pipe, std::int64_t most_bytes, const std::function<void()>& work) {
  silence();
  limit_process(most_bytes);
  leave_signals();
  try {
    work();
  } catch (const Error& error) {
    const std::string text = static_cast<char>(error.code()) + std::string(error.what());
    const ssize_t written = write(pipe, text.data(), text.size());
    _exit(written == static_cast<ssize_t>(text.size()) ? kThrewError : kThrewOther);
  } catch (const std::bad_alloc&) {
    _exit(kNoMemory);
  } catch (...) {
    _exit(kThrewOther);
  }
  _exit(kReturned);
}

std::string read_all(int pipe) {
  std::string text;
  std::array<char, 4096> bytes;
  for (ssize_t got = 1; got != 0;) {
    got = read(pipe, bytes.data(), bytes.size());
    if (got < 0 && errno != EINTR) break;
    if (got > 0) text.append(bytes.data(), static_cast<std::size_t>(got));
  }
  return text;
}

}  // namespace

std::int64_t memory_left() {
  rlimit memory{};
  if (getrlimit(RLIMIT_AS, &memory) != 0 || memory.rlim_cur == RLIM_INFINITY)
    return std::numeric_limits<std::int64_t>::max();
  return static_cast<std::int64_t>(memory.rlim_cur) - address_space();
}

bool survives(std::int64_t most_bytes, const std::function<void()>& work) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return true;
  const pid_t child = fork();
  if (child == 0) run_trial(ends[1], most_bytes, work);
  close(ends[1]);
  const std::string message = child > 0 ? read_all(ends[0]) : std::string();
  close(ends[0]);
  if (child < 0) return true;
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status) && std::find(std::begin(kInterrupts), std::end(kInterrupts),
                                       WTERMSIG(status)) != std::end(kInterrupts)) {
    throw Error(ErrorCode::cancelled, "interrupted while reading: nothing was written");
  }
  if (!WIFEXITED(status)) return false;
  if (WEXITSTATUS(status) == kThrewError && !message.empty()) {
    throw Error(static_cast<ErrorCode>(static_cast<unsigned char>(message.front())),
                message.substr(1));
  }
  if (WEXITSTATUS(status) == kNoMemory && memory_left() < most_bytes) throw std::bad_alloc();
  return WEXITSTATUS(status) == kReturned;
}

}  // namespace vasamesh
