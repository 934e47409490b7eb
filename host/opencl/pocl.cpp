#include "opencl/pocl.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>
#include <system_error>

#include "opencl/kernel_folder.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

namespace fs = std::filesystem;

constexpr char kVariable[] = "POCL_CACHE_DIR";

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// Nobody else can write there: what it holds is run. Empty where it cannot be had.
fs::path own_temporary_folder() {
  std::error_code failed;
  const fs::path folder =
      fs::temp_directory_path(failed) / ("vasamesh-" + std::to_string(geteuid()));
  if (failed) return {};
  mkdir(folder.c_str(), S_IRWXU);
  struct stat status {};
  const bool is_own = lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
                      status.st_uid == geteuid() && !(status.st_mode & (S_IWGRP | S_IWOTH));
  return is_own ? folder : fs::path{};
}

/// The process's folder, or why it has none.
class Place {
 public:
  Place() {
    if (const std::string named = variable(kVariable); !named.empty()) {
      if (!take(fs::path(named) / "vasamesh"))
        lack_ = "has no folder for its kernels: " + reasons_ + ", which " + kVariable +
                " names: set it to another, or unset it";
      return;
    }
    for (const fs::path& parent : {default_cache_folder(), own_temporary_folder()})
      if (!parent.empty() && take(parent / "pocl")) return;
    lack_ = "has no folder for its kernels" + (reasons_.empty() ? "" : ": " + reasons_) + ": set " +
            kVariable + " to one that can be written";
  }
  const std::optional<KernelFolder>& folder() const { return folder_; }
  const std::string& lack() const { return lack_; }

 private:
  bool take(const fs::path& path) {
    try {
      folder_.emplace(path);
      return true;
    } catch (const Error& error) {
      reasons_ += (reasons_.empty() ? "" : ", ") + path.string() + " " + error.what();
      return false;
    }
  }

  std::optional<KernelFolder> folder_;
  std::string reasons_, lack_;
};

/// Outlives every backend, also those of static objects.
const Place& place() {
  static const Place& place = *[] {
    std::atexit([] { record_pocl_kernels(); });
    return new Place;
  }();
  return place;
}

bool has_linker() {
  std::istringstream folders(variable("PATH"));
  for (std::string folder; std::getline(folders, folder, ':');)
    if (access((fs::path(folder) / "ld").c_str(), X_OK) == 0) return true;
  return false;
}

}  // namespace

void start_pocl(const std::function<void()>& list_devices) {
  if (!place().folder()) return list_devices();
  const std::string before = variable(kVariable);
  setenv(kVariable, place().folder()->files().c_str(), 1);
  list_devices();
  if (before.empty())
    unsetenv(kVariable);
  else
    setenv(kVariable, before.c_str(), 1);
}

const std::string& pocl_lacks_folder() { return place().lack(); }

std::string pocl_lacks() {
  if (!place().lack().empty() || has_linker()) return place().lack();
  return "needs the linker ld, which is not on PATH: install it (binutils) or set PATH";
}

void record_pocl_kernels() noexcept {
  if (place().folder()) place().folder()->record();
}

}  // namespace vasamesh
