#pragma once

/// \file
/// A folder in which a driver keeps the kernels that it builds, and reads them back unchecked. This
/// checks for it: beside the driver's files lies a record of them, and what is not as recorded (by
/// damage, or of a process that was killed) is removed, so that the driver builds it anew. Any
/// number of processes may share the folder; only one that is alone in it removes anything, before
/// its driver starts.

#include <filesystem>
#include <map>
#include <string>

#include "opencl/program_cache.h"

namespace vasamesh {

class KernelFolder {
 public:
  /// Makes the folder, takes it for this process, and checks it unless others are at work in it.
  /// \throws Error no_device, in words that follow the folder's name: it cannot be written, is
  ///         mounted noexec or has less than 32 MiB of room (a shape's kernels take 2 MB, all that
  ///         tuning builds 16 MB).
  explicit KernelFolder(const std::filesystem::path& folder);
  KernelFolder(const KernelFolder&) = delete;
  KernelFolder& operator=(const KernelFolder&) = delete;

  /// For the driver: files appear there whole, under a name of their own; those that lie in no
  /// folder of it are temporary.
  const std::filesystem::path& files() const { return files_; }

  /// Adds what the driver has built since. What was recorded stays so: damage shows later.
  void record() const noexcept;

 private:
  using Contents = std::map<std::string, std::string>;  // size and hash, by path

  /// Held by whoever uses the folder, alone by one who checks it.
  class Lock {
   public:
    explicit Lock(const std::filesystem::path& file);
    ~Lock();
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;
    bool take_alone() const;
    void share() const;

   private:
    int descriptor_;
  };

  Contents recorded() const;
  void remove_unrecorded() const;
  void check_room() const;

  std::filesystem::path files_;
  ProgramCache records_;
  Lock lock_;
};

}  // namespace vasamesh
