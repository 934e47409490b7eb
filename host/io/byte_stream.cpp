#include "io/byte_stream.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <limits>
#include <system_error>

#include "io/io_error.h"

namespace vasamesh {
namespace {

constexpr std::size_t kInputBytes = std::size_t{1} << 18;
constexpr int kDetectGzipOrZlib = 15 + 32;

}  // namespace

ByteStream::ByteStream(const std::string& path, std::int64_t offset, Encoding encoding)
    : path_(path), file_(std::fopen(path.c_str(), "rb")), encoding_(encoding) {
  if (!file_) {
    throw_bad_input(path, std::string("cannot be opened (") + std::strerror(errno) + ")",
                    "check its name and permissions");
  }
  if (fseeko(file_.get(), static_cast<off_t>(offset), SEEK_SET) != 0) {
    throw_bad_input(path, "truncated", "get a whole copy of the file");
  }
  if (encoding_ == Encoding::raw) return;
  input_.resize(kInputBytes);
  if (inflateInit2(&zlib_, kDetectGzipOrZlib) != Z_OK) throw std::bad_alloc();
}

ByteStream::~ByteStream() {
  if (encoding_ == Encoding::deflate) inflateEnd(&zlib_);
}

std::size_t ByteStream::read(void* to, std::size_t bytes) {
  return encoding_ == Encoding::raw ? read_raw(to, bytes) : inflate_to(to, bytes);
}

void ByteStream::skip(std::int64_t bytes) {
  std::vector<unsigned char> sink(kInputBytes);
  while (bytes > 0) {
    const auto step =
        static_cast<std::size_t>(std::min(bytes, static_cast<std::int64_t>(sink.size())));
    if (read(sink.data(), step) != step) {
      throw_bad_input(path_, "truncated", "get a whole copy of the file");
    }
    bytes -= static_cast<std::int64_t>(step);
  }
}

std::int64_t ByteStream::finish() {
  std::vector<unsigned char> sink(kInputBytes);
  std::int64_t left = 0;
  while (const std::size_t bytes = read(sink.data(), sink.size())) {
    left += static_cast<std::int64_t>(bytes);
  }
  return left;
}

std::size_t ByteStream::read_raw(void* to, std::size_t bytes) {
  const std::size_t got = std::fread(to, 1, bytes, file_.get());
  if (got < bytes && std::ferror(file_.get())) {
    throw_bad_input(path_, std::string("cannot be read (") + std::strerror(errno) + ")",
                    "check the disk and the permissions");
  }
  return got;
}

bool ByteStream::refill() {
  zlib_.next_in = input_.data();
  zlib_.avail_in = static_cast<uInt>(read_raw(input_.data(), input_.size()));
  return zlib_.avail_in > 0;
}

// A gzip file may hold several members, one after the other; anything else that follows the end is
// padding.
bool ByteStream::start_next_member() {
  if (zlib_.avail_in == 0 && !refill()) return false;
  return zlib_.next_in[0] == 0x1f && inflateReset(&zlib_) == Z_OK;
}

std::size_t ByteStream::inflate_to(void* to, std::size_t bytes) {
  zlib_.next_out = static_cast<Bytef*>(to);
  zlib_.avail_out = static_cast<uInt>(bytes);
  while (zlib_.avail_out > 0 && !ended_) {
    if (zlib_.avail_in == 0 && !refill()) {
      throw_bad_input(path_, "truncated: its compressed data end early",
                      "get a whole copy of the file");
    }
    const int code = inflate(&zlib_, Z_NO_FLUSH);
    if (code == Z_STREAM_END) {
      ended_ = !start_next_member();
    } else if (code != Z_OK && code != Z_BUF_ERROR) {
      throw_bad_input(path_, "corrupt: its compressed data do not match their checksum",
                      "get a whole copy of the file");
    }
  }
  return bytes - zlib_.avail_out;
}

std::int64_t file_size(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw_bad_input(path, "no such file", "check the name");
  }
  const auto bytes = std::filesystem::file_size(path, error);
  if (error) throw_bad_input(path, "not a regular file", "give a file");
  if (bytes == 0) throw_bad_input(path, "empty file", "get a whole copy of the file");
  return static_cast<std::int64_t>(bytes);
}

std::int64_t decoded_bound(std::int64_t bytes, Encoding encoding) {
  constexpr std::int64_t kDeflateRatio = 1032;
  if (encoding == Encoding::raw) return bytes;
  return bytes > std::numeric_limits<std::int64_t>::max() / kDeflateRatio
             ? std::numeric_limits<std::int64_t>::max()
             : bytes * kDeflateRatio;
}

}  // namespace vasamesh
