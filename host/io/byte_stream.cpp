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
constexpr std::uint8_t kGzipMagic = 0x1f;  // no zlib stream begins so

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
  inflate_ = std::make_unique_for_overwrite<inflate_state>();
  isal_inflate_init(inflate_.get());
  if (!start_first_member()) throw_truncated();
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

void ByteStream::throw_truncated() const {
  throw_bad_input(path_, "truncated: its compressed data end early",
                  "get a whole copy of the file");
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
  inflate_->next_in = input_.data();
  inflate_->avail_in = static_cast<std::uint32_t>(read_raw(input_.data(), input_.size()));
  return inflate_->avail_in > 0;
}

bool ByteStream::start_first_member() {
  if (!refill()) return false;
  inflate_->crc_flag = inflate_->next_in[0] == kGzipMagic ? ISAL_GZIP : ISAL_ZLIB;
  return true;
}

// A gzip file may hold several members, one after the other; anything else that follows the end is
// padding.
bool ByteStream::start_next_member() {
  if (inflate_->crc_flag != ISAL_GZIP) return false;
  if (inflate_->avail_in == 0 && !refill()) return false;
  if (inflate_->next_in[0] != kGzipMagic) return false;
  isal_inflate_reset(inflate_.get());
  return true;
}

// ISA-L returns when the input or the output is used up; it may have output left of input that is.
std::size_t ByteStream::inflate_to(void* to, std::size_t bytes) {
  inflate_->next_out = static_cast<std::uint8_t*>(to);
  inflate_->avail_out = static_cast<std::uint32_t>(bytes);
  while (inflate_->avail_out > 0 && !ended_) {
    if (isal_inflate(inflate_.get()) != ISAL_DECOMP_OK) {
      throw_bad_input(path_, "corrupt: its compressed data do not match their checksum",
                      "get a whole copy of the file");
    }
    if (inflate_->block_state == ISAL_BLOCK_FINISH)
      ended_ = !start_next_member();
    else if (inflate_->avail_out > 0 && !refill())
      throw_truncated();
  }
  return bytes - inflate_->avail_out;
}

std::int64_t file_size(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) {
    throw_bad_input(path, "no such file", "check the name");
  }
  if (status.type() == std::filesystem::file_type::none) {
    throw_bad_input(path, "cannot be opened (" + error.message() + ")",
                    "check its name and the permissions of its folders");
  }
  const auto bytes = std::filesystem::file_size(path, error);
  if (error) throw_bad_input(path, "not a regular file", "give a file");
  if (bytes == 0) throw_bad_input(path, "empty file", "get a whole copy of the file");
  return static_cast<std::int64_t>(bytes);
}

std::string whole_file(const std::string& path) {
  std::string bytes(static_cast<std::size_t>(file_size(path)), '\0');
  bytes.resize(ByteStream(path, 0, Encoding::raw).read(bytes.data(), bytes.size()));
  return bytes;
}

std::int64_t decoded_bound(std::int64_t bytes, Encoding encoding) {
  constexpr std::int64_t kDeflateRatio = 1032;
  if (encoding == Encoding::raw) return bytes;
  return bytes > std::numeric_limits<std::int64_t>::max() / kDeflateRatio
             ? std::numeric_limits<std::int64_t>::max()
             : bytes * kDeflateRatio;
}

}  // namespace vasamesh
