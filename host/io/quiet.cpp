#include "io/quiet.h"

#include <gdcmTrace.h>
#include <itkObject.h>

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

}  // namespace

Quiet::Quiet()
    : cout_(std::cout.rdbuf(&null_buffer())),
      cerr_(std::cerr.rdbuf(&null_buffer())),
      itk_warnings_(itk::Object::GetGlobalWarningDisplay()) {
  itk::Object::GlobalWarningDisplayOff();
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
}

Quiet::~Quiet() {
  std::cout.rdbuf(cout_);
  std::cerr.rdbuf(cerr_);
  itk::Object::SetGlobalWarningDisplay(itk_warnings_);
}

}  // namespace vasamesh
