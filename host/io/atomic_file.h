#pragma once

/// \file
/// Output that appears whole or not at all: written under a temporary name in the same folder,
/// renamed when it is complete, removed on every other way out. A file that is replaced leaves its
/// permissions to the new one. Where a symbolic link has the name, the file that it leads to is
/// replaced, and the link stays.

#include <sys/types.h>

#include <atomic>
#include <string>
#include <string_view>

namespace vasamesh {

/// A file being written. The object's end without commit() removes what was written and leaves an
/// old file of that name as it was.
class AtomicFile {
 public:
  /// \param cancel  keeps commit() from renaming once it is set; may be null.
  /// \throws Error refused, as check_writable.
  explicit AtomicFile(const std::string& path, const std::atomic<bool>* cancel = nullptr);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Where to write: a new name in the folder of the file, with its ending.
  const std::string& temporary() const { return temporary_; }

  /// The permissions of the file that is to be replaced; 0 where there is none.
  mode_t mode() const;

  /// Renames the temporary file to `path`. \throws Error refused, cancelled.
  void commit();

 private:
  std::string path_, file_, temporary_;
  const std::atomic<bool>* cancel_;
  bool committed_ = false;
};

/// What `path` names through symbolic links, whether it is there or not.
std::string linked_file(const std::string& path);

/// \throws Error refused when no file of the name `path` could be created: the folder is missing or
///         not writable, the name is too long, or `path` is a folder, a device or a pipe.
void check_writable(const std::string& path);

/// Writes `bytes` as the whole content of `path`.
/// \throws Error refused, cancelled when `cancel` was set before they were all written.
void write_file(const std::string& path, std::string_view bytes,
                const std::atomic<bool>* cancel = nullptr);

}  // namespace vasamesh
