#include "io/quiet.h"

#include <fcntl.h>
#include <gdcmTrace.h>
#include <itkObject.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

namespace vasamesh {
namespace {

/// Takes everything and keeps nothing.
class NullBuffer : public std::streambuf {
 protected:
  int_type overflow(int_type c) override { return traits_type::not_eof(c); }
  std::streamsize xsputn(const char*, std::streamsize count) override { return count; }
};

NullBuffer& null_buffer() {
  static NullBuffer buffer;
  return buffer;
}

/// Points the descriptor of stderr at nothing and \return a copy of what it was.
int close_stderr() {
  std::fflush(stderr);
  const int copy = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (copy >= 0 && nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  if (nowhere >= 0) close(nowhere);
  return copy;
}

void reopen_stderr(int copy) {
  if (copy < 0) return;
  std::fflush(stderr);
  dup2(copy, STDERR_FILENO);
  close(copy);
}

}  // namespace

Quiet::Quiet()
    : cout_(std::cout.rdbuf(&null_buffer())),
      stderr_(close_stderr()),
      itk_warnings_(itk::Object::GetGlobalWarningDisplay()) {
  itk::Object::GlobalWarningDisplayOff();
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
}

Quiet::~Quiet() {
  std::cout.rdbuf(cout_);
  reopen_stderr(stderr_);
  itk::Object::SetGlobalWarningDisplay(itk_warnings_);
}

}  // namespace vasamesh
