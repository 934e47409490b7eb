#pragma once

/// \file
/// Built programs on disk: one file a key. Files are written under a temporary name and renamed, so
/// that any number of processes may share a folder; a file that is damaged or of another key counts
/// as absent. Nothing here throws: a cache that cannot be used costs a build.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace vasamesh {

/// Tells contents apart that differ by chance, not by intent; some GB/s.
std::uint64_t hash_of(std::string_view bytes);

/// $XDG_CACHE_HOME/vasamesh or ~/.cache/vasamesh; empty where neither variable is set.
std::filesystem::path default_cache_folder();

class ProgramCache {
 public:
  /// \param folder  made when it is first needed; empty: default_cache_folder(), and no cache
  ///        where that is empty.
  explicit ProgramCache(std::filesystem::path folder);

  /// What was stored under the key, whole and unchanged.
  std::optional<std::string> load(const std::string& key) const;
  /// \return whether it could be.
  bool store(const std::string& key, const std::string& binary) const;
  void remove(const std::string& key) const;

  /// The key's file.
  std::filesystem::path path(const std::string& key) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace vasamesh
