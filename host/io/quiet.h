#pragma once

/// \file
/// Keeps ITK, GDCM and MetaIO from printing: what they have to say comes as an Error.

#include <streambuf>

namespace vasamesh {

/// Silences the libraries, and std::cout and std::cerr, for its lifetime.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  std::streambuf* cout_;
  std::streambuf* cerr_;
  bool itk_warnings_;
};

}  // namespace vasamesh
