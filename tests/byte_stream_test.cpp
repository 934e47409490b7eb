/// \file
/// Deflate streams against what zlib has packed: members whose ends and beginnings fall on every
/// place round the end of the reader's buffer, headers with all fields, and streams that are cut
/// short or altered anywhere.

#include "io/byte_stream.h"

#include <gtest/gtest.h>

#include <random>

#include "support/scratch.h"
#include "support/volume_files.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 18;  // what the reader takes at once
constexpr int kStored = 0, kUsual = 6;                 // levels of zlib

std::string random_bytes(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::string bytes(count, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

std::string zlib_stream(const std::string& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(size, '\0');
  compress(reinterpret_cast<Bytef*>(out.data()), &size,
           reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()));
  out.resize(size);
  return out;
}

class Streams : public ::testing::Test {
 protected:
  /// What is decoded of a file that holds `bytes`, in portions of `portion`.
  std::string decoded(const std::string& bytes, std::size_t portion = 1000) {
    const std::string path = scratch_ / "stream";
    write_text(path, bytes);
    ByteStream stream(path, 0, Encoding::deflate);
    std::string all, part(portion, '\0');
    while (const std::size_t got = stream.read(part.data(), portion)) all.append(part, 0, got);
    EXPECT_EQ(stream.finish(), 0);
    return all;
  }

  void expect_refused(const std::string& bytes, const std::string& what) {
    try {
      decoded(bytes);
      ADD_FAILURE() << what << " was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input) << what;
    }
  }

  Scratch scratch_;
};

TEST_F(Streams, MembersEndAnywhereInTheBuffer) {
  const std::string second = random_bytes(700, 2);
  const std::size_t overhead = gzip(std::string(kBuffer, 'x'), kStored).size() - kBuffer;
  for (std::size_t before = 0; before <= 40; ++before) {
    const std::string first = random_bytes(kBuffer - overhead + 20 - before, 1);
    const std::string file = gzip(first, kStored) + gzip(second, kUsual);
    EXPECT_EQ(decoded(file), first + second) << before;
    EXPECT_EQ(decoded(file, first.size()), first + second) << before;
  }
}

TEST_F(Streams, PortionsOfAnySize) {
  const std::string bytes =
      std::string(100'000, 'v') + random_bytes(300'000, 3) + std::string(50'000, '\0');
  for (const std::size_t portion : {std::size_t{7}, std::size_t{4096}, bytes.size()}) {
    EXPECT_EQ(decoded(gzip(bytes), portion), bytes) << portion;
    EXPECT_EQ(decoded(zlib_stream(bytes), portion), bytes) << portion;
  }
}

TEST_F(Streams, NothingInAMemberAndPaddingBehind) {
  const std::string bytes = "some bytes";
  EXPECT_EQ(decoded(gzip("")), "");
  EXPECT_EQ(decoded(gzip("") + gzip(bytes) + gzip("") + std::string(512, '\0')), bytes);
  EXPECT_EQ(decoded(zlib_stream(bytes) + "padding"), bytes);
}

TEST_F(Streams, AHeaderWithAllItsFields) {
  const std::string plain = gzip("some bytes");
  std::string header = plain.substr(0, 10);
  header[3] = 4 + 8 + 16;  // extra field, name, comment
  const std::string fields =
      std::string("\5\0extra", 7) + std::string("name\0", 5) + std::string("comment\0", 8);
  EXPECT_EQ(decoded(header + fields + plain.substr(10)), "some bytes");
}

TEST_F(Streams, CutShortOrAlteredAnywhere) {
  const std::string bytes = std::string(3000, 'v') + random_bytes(100, 4) + std::string(3000, '\0');
  for (const std::string& whole : {gzip(bytes), zlib_stream(bytes)}) {
    for (std::size_t size = 0; size < whole.size(); ++size)
      expect_refused(whole.substr(0, size), "the first " + std::to_string(size) + " bytes");
    for (std::size_t i = whole.size() - 4; i < whole.size(); ++i) {
      std::string altered = whole;
      altered[i] = static_cast<char>(altered[i] ^ 1);
      expect_refused(altered, "byte " + std::to_string(i) + " altered");
    }
  }
  std::string checksum = gzip(bytes);
  checksum[checksum.size() - 8] ^= 1;
  expect_refused(checksum, "a wrong checksum");
  expect_refused("\x1f no gzip at all", "another format");
}

}  // namespace
}  // namespace vasamesh
