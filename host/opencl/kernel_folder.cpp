#include "opencl/kernel_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <system_error>
#include <thread>
#include <vector>

#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kRoom = 32 << 20, kMost = 32 << 20;  // bytes
constexpr std::size_t kProbe = 64 << 10;
constexpr char kRecord[] = "kernels 1";
constexpr std::chrono::milliseconds kPause{5};
constexpr int kPauses = 400;  // a check takes some milliseconds

[[noreturn]] void refuse(const std::string& why) { throw Error(ErrorCode::no_device, why); }

std::string last_error() { return std::generic_category().message(errno); }

fs::path made(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) refuse("cannot be made (" + failed.message() + ")");
  return folder;
}

/// All but folders, by their paths in `folder`.
std::vector<std::string> files_in(const fs::path& folder) {
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (!entry.is_directory() || entry.is_symlink())
      files.push_back(entry.path().string().substr(folder.string().size() + 1));
  return files;
}

std::uint64_t size_of(const fs::path& file) {
  std::error_code failed;
  const std::uint64_t size = fs::file_size(file, failed);
  return failed ? 0 : size;
}

/// "<size> <hash>"; empty of what is no file that can be read.
std::string seal_of(const fs::path& path) {
  if (!fs::is_regular_file(fs::symlink_status(path))) return {};
  std::string content(size_of(path), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(content.data(), static_cast<std::streamsize>(content.size()));
  if (!file) return {};
  return std::to_string(content.size()) + " " + std::to_string(hash_of(content));
}

/// What a file may still take: of the file system, and of the process's limit.
std::uint64_t room_in(const struct statvfs& system) {
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const std::uint64_t free = std::uint64_t{system.f_bavail} * system.f_frsize;
  return std::min<std::uint64_t>(free, limit.rlim_cur);
}

}  // namespace

KernelFolder::Lock::Lock(const fs::path& file)
    : descriptor_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666)) {
  if (descriptor_ < 0) refuse("cannot be written (" + last_error() + ")");
}

KernelFolder::Lock::~Lock() { close(descriptor_); }

bool KernelFolder::Lock::take_alone() const { return flock(descriptor_, LOCK_EX | LOCK_NB) == 0; }

void KernelFolder::Lock::share() const {
  for (int pause = 0; flock(descriptor_, LOCK_SH | LOCK_NB) != 0; ++pause) {
    if (errno != EWOULDBLOCK && errno != EINTR) refuse("cannot be locked (" + last_error() + ")");
    if (pause == kPauses) refuse("is held by another process");
    std::this_thread::sleep_for(kPause);
  }
}

KernelFolder::KernelFolder(const fs::path& folder)
    : files_(made(folder / "files")), records_(folder), lock_(folder / "lock") {
  if (lock_.take_alone()) remove_unrecorded();
  lock_.share();
  check_room();
}

void KernelFolder::record() const noexcept try {
  const Contents before = recorded();
  Contents now;
  for (const std::string& file : files_in(files_)) {
    if (file.find('/') == std::string::npos) continue;
    const auto known = before.find(file);
    const std::string seal = known == before.end() ? seal_of(files_ / file) : known->second;
    if (!seal.empty()) now.emplace(file, seal);
  }
  if (now == before) return;
  std::string text;
  for (const auto& [file, seal] : now) text.append(seal).append(" ").append(file).append("\n");
  records_.store(kRecord, text);
} catch (const std::exception&) {  // what is not recorded costs a build
}

KernelFolder::Contents KernelFolder::recorded() const {
  std::istringstream lines(records_.load(kRecord).value_or(""));
  Contents contents;
  for (std::string size, hash, file; lines >> size >> hash && std::getline(lines >> std::ws, file);)
    contents.emplace(file, size.append(" ").append(hash));
  return contents;
}

/// Of a folder that has grown too large nothing is kept.
void KernelFolder::remove_unrecorded() const try {
  const std::vector<std::string> files = files_in(files_);
  std::uint64_t bytes = 0;
  for (const std::string& file : files) bytes += size_of(files_ / file);
  const Contents kept = bytes > kMost ? Contents{} : recorded();
  for (const std::string& file : files) {
    const auto known = kept.find(file);
    if (known == kept.end() || known->second != seal_of(files_ / file)) fs::remove(files_ / file);
  }
} catch (const fs::filesystem_error& error) {
  refuse("cannot be read (" + error.code().message() + ")");
}

/// Drivers need to write also where everything is built.
void KernelFolder::check_room() const {
  struct statvfs system {};
  if (statvfs(files_.c_str(), &system) != 0) refuse("cannot be read (" + last_error() + ")");
  if (system.f_flag & ST_NOEXEC) refuse("is mounted noexec");
  if (const std::uint64_t room = room_in(system); room < kRoom)
    refuse("has room for " + std::to_string(room >> 10) + " kB, not for " +
           std::to_string(kRoom >> 10) + " kB");
  const ProgramCache probe(files_);
  const bool written = probe.store("probe", std::string(kProbe, 'x'));
  probe.remove("probe");
  if (!written) refuse("cannot be written");
}

}  // namespace vasamesh
