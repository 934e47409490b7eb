#pragma once

/// \file
/// Keeps ITK, GDCM, MetaIO and niftilib from printing: what they have to say comes as an Error.

#include <streambuf>

namespace vasamesh {

/// Silences the libraries for its lifetime: std::cout, and the descriptor of stderr. Nothing of
/// ours may print meanwhile.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  std::streambuf* cout_;
  int stderr_;  ///< a copy of its descriptor; -1 when it is closed
  bool itk_warnings_;
};

}  // namespace vasamesh
