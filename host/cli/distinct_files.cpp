#include "cli/distinct_files.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "io/atomic_file.h"
#include "io/file_ending.h"
#include "vasamesh/errors.h"

namespace vasamesh::cli {

namespace {

namespace fs = std::filesystem;

/// One path for all spellings of it, of a file that may not be there yet.
fs::path resolved(const std::string& path) {
  std::error_code error;
  const fs::path whole = fs::absolute(linked_file(path), error);
  const fs::path file = fs::weakly_canonical(whole, error);
  return error ? whole.lexically_normal() : file;
}

/// Hard links are one file under two names.
bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) || resolved(a) == resolved(b);
}

/// Whether `path` is a file of `folder`, also under another name, that may be one of its slices:
/// any but what an earlier run has left there.
bool may_be_slice(const std::string& path, const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error) || !fs::exists(path, error)) return false;
  if (!file_ending(resolved(path).string(), {".vtp", ".stl", ".ply", ".obj", ".json"}).empty())
    return false;
  if (resolved(path).parent_path() == resolved(folder)) return true;
  const fs::directory_iterator entries(folder, error);
  return !error && std::any_of(begin(entries), end(entries), [&](const fs::directory_entry& entry) {
    return fs::equivalent(path, entry.path(), error);
  });
}

[[noreturn]] void throw_same(const NamedFile& output, const NamedFile& other) {
  throw Error(ErrorCode::usage,
              output.name + " names the same file as " + other.name + ": give it another name");
}

}  // namespace

void check_distinct(const std::vector<NamedFile>& inputs, const std::vector<NamedFile>& outputs) {
  for (auto output = outputs.begin(); output != outputs.end(); ++output) {
    if (output->path.empty()) continue;
    for (const NamedFile& input : inputs) {
      if (input.path.empty()) continue;
      if (is_same_file(output->path, input.path)) throw_same(*output, input);
      if (may_be_slice(output->path, input.path))
        throw Error(ErrorCode::usage, output->name + " names a file of the folder " + input.name +
                                          ": give it another name");
    }
    for (auto other = outputs.begin(); other != output; ++other)
      if (!other->path.empty() && is_same_file(output->path, other->path))
        throw_same(*output, *other);
  }
}

}  // namespace vasamesh::cli
