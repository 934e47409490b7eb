/// \file
/// The picture program, run as the demo runs it: without a display of its own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "support/scratch.h"
#include "support/spawn.h"

namespace vasamesh {
namespace {

using testing::HasSubstr;

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

int big_endian(const std::string& bytes, std::size_t at) {
  int value = 0;
  for (std::size_t i = at; i < at + 4; ++i)
    value = 256 * value + static_cast<unsigned char>(bytes[i]);
  return value;
}

class Picture : public testing::Test {
 protected:
  Picture() {
    unsetenv("DISPLAY");
    setenv("ASAN_OPTIONS", "detect_leaks=0", 1);  // the display's drivers keep memory
    std::ofstream(surface_) << "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\n"
                               "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  }

  Outcome run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), VASAMESH_PICTURE);
    return run_program(arguments);
  }

  Scratch scratch_;
  std::string surface_ = scratch_ / "surface.obj";
  std::string picture_ = scratch_ / "picture.png";
};

TEST_F(Picture, HasTheSizeAskedForAndMoreThanBackground) {
  if (std::system("command -v Xvfb >/dev/null") != 0) GTEST_SKIP() << "no Xvfb here";
  const Outcome blank = run({surface_, scratch_ / "blank.png", "--size", "320x240", "--zoom-to",
                             "500", "500", "500", "1"});
  const Outcome full = run({surface_, picture_, "--size", "320x240", "--edges"});
  EXPECT_EQ(blank.code, 0) << blank.err;
  EXPECT_EQ(full.code, 0) << full.err;
  const std::string bytes = bytes_of(picture_);
  ASSERT_GT(bytes.size(), 24u);
  EXPECT_EQ(bytes.substr(1, 3), "PNG");
  EXPECT_EQ(big_endian(bytes, 16), 320);
  EXPECT_EQ(big_endian(bytes, 20), 240);
  EXPECT_GT(bytes.size(), 2 * bytes_of(scratch_ / "blank.png").size());
}

TEST_F(Picture, NamesAFileThatIsNotThere) {
  if (std::system("command -v Xvfb >/dev/null") != 0) GTEST_SKIP() << "no Xvfb here";
  const Outcome outcome = run({scratch_ / "none.ply", picture_});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("none.ply"));
  EXPECT_FALSE(std::filesystem::exists(picture_));
}

TEST_F(Picture, RefusesAnOptionOutOfRange) {
  EXPECT_EQ(run({surface_, picture_, "--view", "0", "0", "0"}).code, 2);
  EXPECT_EQ(run({surface_, picture_, "--size", "12"}).code, 2);
  EXPECT_EQ(run({surface_, picture_, "--zoom-to", "0", "0", "0", "-1"}).code, 2);
  EXPECT_EQ(run({surface_}).code, 2);
}

}  // namespace
}  // namespace vasamesh
