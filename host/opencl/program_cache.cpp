#include "opencl/program_cache.h"

#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

namespace vasamesh {

namespace {

namespace fs = std::filesystem;

constexpr char kMagic[] = "vasamesh program 2\n";

std::string hexadecimal(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(value));
  return text;
}

/// A file is its prefix, its seal and the binary. The prefix holds the key in full, so that a
/// colliding hash does no harm; the seal the binary's size and hash, so that damage shows.
std::string prefix_of(const std::string& key) {
  std::string prefix = kMagic;
  prefix += std::to_string(key.size());
  prefix += "\n";
  return prefix + key + "\n";
}

std::string seal_of(const std::string& binary) {
  return std::to_string(binary.size()) + " " + hexadecimal(hash_of(binary)) + "\n";
}

bool write_file(const fs::path& path, const std::string& content) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  file.close();
  return file.good();
}

}  // namespace

/// FNV-1a by words of 64 bits, the upper half of each step folded into the lower.
std::uint64_t hash_of(std::string_view bytes) {
  std::uint64_t value = 0xcbf29ce484222325u ^ bytes.size();
  const auto add = [&value](std::uint64_t word) {
    value = (value ^ word) * 0x100000001b3u;
    value ^= value >> 32;
  };
  std::uint64_t word = 0;
  for (; bytes.size() >= sizeof(word); bytes.remove_prefix(sizeof(word))) {
    std::memcpy(&word, bytes.data(), sizeof(word));
    add(word);
  }
  word = 0;
  std::memcpy(&word, bytes.data(), bytes.size());
  add(word);
  return value;
}

fs::path default_cache_folder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache)
    return fs::path(cache) / "vasamesh";
  if (const char* home = std::getenv("HOME"); home && *home)
    return fs::path(home) / ".cache" / "vasamesh";
  return {};
}

ProgramCache::ProgramCache(fs::path folder)
    : folder_(folder.empty() ? default_cache_folder() : std::move(folder)) {}

fs::path ProgramCache::path(const std::string& key) const {
  return folder_ / (hexadecimal(hash_of(key)) + ".clbin");
}

std::optional<std::string> ProgramCache::load(const std::string& key) const {
  if (folder_.empty()) return std::nullopt;
  std::ifstream file(path(key), std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(file), {}};
  const std::string prefix = prefix_of(key);
  if (!content.starts_with(prefix)) return std::nullopt;
  const std::size_t seal_end = content.find('\n', prefix.size());
  if (seal_end == std::string::npos) return std::nullopt;
  std::string binary = content.substr(seal_end + 1);
  if (content.compare(prefix.size(), seal_end + 1 - prefix.size(), seal_of(binary)) != 0)
    return std::nullopt;
  return binary;
}

bool ProgramCache::store(const std::string& key, const std::string& binary) const {
  static std::atomic<unsigned> counter{0};
  if (folder_.empty()) return false;
  std::error_code ignored, failed;
  fs::create_directories(folder_, ignored);
  const fs::path file = path(key);
  fs::path temporary = file;
  for (const long part : {static_cast<long>(getpid()), static_cast<long>(counter++)})
    temporary.concat(".").concat(std::to_string(part));
  const bool written = write_file(temporary, prefix_of(key) + seal_of(binary) + binary);
  if (written) fs::rename(temporary, file, failed);
  fs::remove(temporary, ignored);
  return written && !failed;
}

void ProgramCache::remove(const std::string& key) const {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove(path(key), ignored);
}

}  // namespace vasamesh
