#pragma once

/// \file
/// The bytes of a file, or of a part of it, decompressed as they are read and proven by their
/// checksum at the end. Image libraries stop at the last voxel and so never see the checksum.
/// Deflate (RFC 1950 to 1952) is decoded by ISA-L, several times as fast as by zlib.

#include <isa-l/igzip_lib.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace vasamesh {

enum class Encoding { raw, deflate };  ///< deflate: a zlib stream, or one or more gzip members

/// Reads forward, once.
class ByteStream {
 public:
  /// From byte `offset` of the file. \throws Error bad_input: no such file, unreadable.
  ByteStream(const std::string& path, std::int64_t offset, Encoding encoding);

  /// Reads up to `bytes`; fewer only at the end. \throws Error bad_input: corrupt, truncated.
  std::size_t read(void* to, std::size_t bytes);

  /// Skips `bytes`. \throws Error bad_input: corrupt, truncated, or they are not there.
  void skip(std::int64_t bytes);

  /// Reads to the end, past the checksum, and \return the bytes that were left.
  std::int64_t finish();

 private:
  std::size_t read_raw(void* to, std::size_t bytes);
  std::size_t inflate_to(void* to, std::size_t bytes);
  bool refill();
  bool start_first_member();
  bool start_next_member();
  [[noreturn]] void throw_truncated() const;

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
  Encoding encoding_;
  std::vector<unsigned char> input_;
  std::unique_ptr<inflate_state> inflate_;  ///< none where nothing is encoded
  bool ended_ = false;
};

/// The size of a regular file. \throws Error bad_input: no such file, not a file, empty.
std::int64_t file_size(const std::string& path);

/// All bytes of a regular file. \throws Error bad_input, as file_size, and when it is unreadable.
std::string whole_file(const std::string& path);

/// The most bytes that a file of `bytes` can hold when decoded: deflate expands 1032-fold at most.
std::int64_t decoded_bound(std::int64_t bytes, Encoding encoding);

}  // namespace vasamesh
