#include "support/spawn.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace vasamesh {

namespace {

struct Pipe {
  int read_end = -1, write_end = -1;
};

Pipe make_pipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  return {ends[0], ends[1]};
}

/// A terminal in place of a pipe.
Pipe make_terminal() {
  Pipe ends;
  if (openpty(&ends.read_end, &ends.write_end, nullptr, nullptr, nullptr) != 0)
    throw std::runtime_error("no terminal");
  fcntl(ends.read_end, F_SETFD, FD_CLOEXEC);
  fcntl(ends.write_end, F_SETFD, FD_CLOEXEC);
  return ends;
}

pid_t start(const std::vector<std::string>& arguments, int out, int err) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child != 0) return child;
  const int null = open("/dev/null", O_RDONLY);
  if (null < 0 || dup2(null, STDIN_FILENO) < 0 || dup2(out, STDOUT_FILENO) < 0 ||
      dup2(err, STDERR_FILENO) < 0)
    _exit(126);
  execv(argv[0], argv.data());
  _exit(127);
}

/// Appends what there is to read. \return false at the end. A closed terminal reads as an error.
bool drain(int descriptor, std::string& text) {
  std::array<char, 4096> bytes{};
  const ssize_t count = read(descriptor, bytes.data(), bytes.size());
  if (count > 0) text.append(bytes.data(), static_cast<std::size_t>(count));
  return count > 0;
}

/// Reads both ends to their closing; sends `signal` to `child` once `err` holds `cue`.
void follow(pid_t child, int out, int err, const std::string& cue, int signal, Outcome& outcome) {
  std::array<pollfd, 2> ends = {{{out, POLLIN, 0}, {err, POLLIN, 0}}};
  bool sent = signal == 0;
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    poll(ends.data(), ends.size(), -1);
    if (ends[0].revents != 0 && !drain(out, outcome.out)) ends[0].fd = -1;
    if (ends[1].revents != 0 && !drain(err, outcome.err)) ends[1].fd = -1;
    if (sent || outcome.err.find(cue) == std::string::npos) continue;
    kill(child, signal);
    sent = true;
  }
}

Outcome run(const std::vector<std::string>& arguments, Pipe out, Pipe err, const std::string& cue,
            int signal) {
  const pid_t child = start(arguments, out.write_end, err.write_end);
  close(out.write_end);
  close(err.write_end);
  Outcome outcome;
  follow(child, out.read_end, err.read_end, cue, signal, outcome);
  close(out.read_end);
  close(err.read_end);
  int status = 0;
  waitpid(child, &status, 0);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1 - WTERMSIG(status);
  return outcome;
}

}  // namespace

Outcome run_program(const std::vector<std::string>& arguments, const std::string& stdout_to) {
  Pipe out = make_pipe();
  if (!stdout_to.empty()) {
    close(out.write_end);
    out.write_end = open(stdout_to.c_str(), O_WRONLY | O_CLOEXEC);
    if (out.write_end < 0) throw std::runtime_error("cannot open " + stdout_to);
  }
  return run(arguments, out, make_pipe(), {}, 0);
}

Outcome interrupt_program(const std::vector<std::string>& arguments, const std::string& cue,
                          int signal) {
  return run(arguments, make_pipe(), make_terminal(), cue, signal);
}

Outcome run_on_terminal(const std::vector<std::string>& arguments) {
  return run(arguments, make_pipe(), make_terminal(), {}, 0);
}

}  // namespace vasamesh
