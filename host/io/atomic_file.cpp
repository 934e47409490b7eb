#include "io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "io/io_error.h"

namespace vasamesh {
namespace {

constexpr std::size_t kLongestEnding = 16;

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

// The last ending, and the one before ".gz" with it; none where it is no ending of a format.
std::string name_ending(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  const std::size_t dot = name.rfind('.');
  if (dot == std::string::npos) return {};
  const std::size_t before = dot == 0 ? std::string::npos : name.rfind('.', dot - 1);
  const bool both = name.ends_with(".gz") && before != std::string::npos;
  const std::string ending = name.substr(both ? before : dot);
  return ending.size() <= kLongestEnding ? ending : std::string();
}

std::string temporary_name(const std::string& path) {
  static std::atomic<unsigned> counter{0};
  const std::string name =
      ".vasamesh-" + std::to_string(getpid()) + "-" + std::to_string(counter++) + name_ending(path);
  return (std::filesystem::path(folder_of(path)) / name).string();
}

/// Devices and pipes, also behind links that only the system can follow (/dev/stdout).
void check_replaceable(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(status)) {
    throw_refused(path, "a folder has this name", "choose another name");
  }
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw_refused(path, "a device or pipe has this name", "give the name of a file");
  }
}

/// A name that the temporary file's, which is short, would not show to be too long.
void check_length(const std::string& path, const std::string& file) {
  struct stat status;
  if (lstat(file.c_str(), &status) != 0 && errno == ENAMETOOLONG)
    throw_refused(path, "this name is longer than the system allows", "choose a shorter name");
}

[[noreturn]] void throw_not_written(const std::string& path) {
  throw_refused(path, std::string("it could not be written (") + std::strerror(errno) + ")",
                "make room on the disk");
}

}  // namespace

std::string linked_file(const std::string& path) {
  constexpr int kMostLinks = 40;  // as many as the system follows
  std::filesystem::path file = path;
  std::error_code error;
  for (int i = 0; i < kMostLinks && std::filesystem::is_symlink(file, error); ++i) {
    file = file.parent_path() / std::filesystem::read_symlink(file, error);
  }
  return file.string();
}

void check_writable(const std::string& path) {
  check_replaceable(path);
  std::error_code error;
  const std::string file = linked_file(path), folder = folder_of(file);
  check_length(path, file);
  if (!std::filesystem::is_directory(folder, error)) {
    throw_refused(path, "the folder " + folder + " does not exist", "make it first");
  }
  const std::string probe = temporary_name(file);
  const int descriptor = open(probe.c_str(), O_WRONLY | O_CREAT | O_EXCL, 0600);
  if (descriptor < 0) {
    throw_refused(path, "the folder " + folder + " is not writable", "choose another folder");
  }
  close(descriptor);
  unlink(probe.c_str());
}

AtomicFile::AtomicFile(const std::string& path, const std::atomic<bool>* cancel)
    : path_(path), file_(linked_file(path)), temporary_(temporary_name(file_)), cancel_(cancel) {
  check_writable(path);
}

AtomicFile::~AtomicFile() {
  std::error_code error;
  if (!committed_) std::filesystem::remove(temporary_, error);
}

mode_t AtomicFile::mode() const {
  struct stat old;
  return stat(file_.c_str(), &old) == 0 ? old.st_mode & 07777 : 0;
}

void AtomicFile::commit() {
  if (cancel_ && *cancel_)
    throw Error(ErrorCode::cancelled, "interrupted: " + path_ + " was not written");
  if (const mode_t old = mode()) chmod(temporary_.c_str(), old);
  if (std::rename(temporary_.c_str(), file_.c_str()) != 0) throw_not_written(path_);
  committed_ = true;
}

void write_file(const std::string& path, std::string_view bytes, const std::atomic<bool>* cancel) {
  AtomicFile file(path, cancel);
  const mode_t old = file.mode();
  const int descriptor =
      open(file.temporary().c_str(), O_WRONLY | O_CREAT | O_TRUNC, old ? old & 0777 : 0666);
  if (descriptor < 0) throw_not_written(path);
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int cause = errno;
      close(descriptor);
      errno = cause;
      throw_not_written(path);
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  if (close(descriptor) != 0) throw_not_written(path);
  file.commit();
}

}  // namespace vasamesh
