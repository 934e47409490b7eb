#pragma once

/// \file
/// The subcommands of the program: what each was asked for, and the function that does it.

#include <optional>
#include <string>
#include <vector>

#include "io/volume_reader.h"
#include "phantom/phantom.h"
#include "vasamesh/host.h"
#include "vasamesh/parameters.h"

namespace vasamesh::cli {

/// `vasamesh convert IN -o OUT`.
struct ConvertRequest {
  std::string input;
  std::string output;
  std::string report;  ///< a .json file; empty: none
  bool quiet = false;
  ReadOptions read;
  Parameters parameters;
  ContextOptions context;
};

/// `vasamesh check SURFACE`.
struct CheckRequest {
  std::string surface;
  std::string volume;     ///< --against; empty: none
  std::string reference;  ///< --reference; empty: none
  std::string map;        ///< --map; empty: none
  bool json = false;
  ReadOptions read;
  Connectivity connectivity = Connectivity::vertex;
  std::optional<Space> space;  ///< of the surface's coordinates; none: what its file says, else LPS
  int threads = 0;
};

/// `vasamesh phantom NAME -o OUT`.
struct PhantomRequest {
  std::string name;
  std::string output;
  std::string surface;  ///< for the exact surface; empty: none
  PhantomOptions options;
};

/// `vasamesh bench IN...`.
struct BenchRequest {
  std::vector<std::string> inputs;
  std::vector<std::string> backends;  ///< empty: all that are here
  std::string device;        ///< OpenCL device: its number, type or a part of its name; empty: all
  std::vector<int> threads;  ///< empty: 1, 2, 4 and so on
  int repeat = 3;
  bool json = false;
  ReadOptions read;
  Parameters parameters;
};

/// `vasamesh tune`.
struct TuneRequest {
  std::string device;  ///< as of ContextOptions; empty: all OpenCL devices
  int threads = 0;     ///< of oneTBB, which devices are compared with
};

/// Each does one whole command; results go to stdout. \throws Error
void run_convert(const ConvertRequest& request);
void run_check(const CheckRequest& request);
void run_phantom(const PhantomRequest& request);
void run_devices();
void run_bench(const BenchRequest& request);
void run_tune(const TuneRequest& request);

}  // namespace vasamesh::cli
