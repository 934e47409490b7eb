/// \file
/// Surfaces out: files that cannot be written, and that replace others whole or not at all.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <filesystem>

#include "io/atomic_file.h"
#include "support/full_disk.h"
#include "support/surface_files.h"

namespace vasamesh {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

ErrorCode code_of(const std::string& path) {
  try {
    check_output_path(path);
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode{0};
}

TEST_F(Surfaces, OutputIsCheckedBeforeAnyWork) {
  EXPECT_EQ(code_of(scratch_ / "a.vtp"), ErrorCode{0});
  EXPECT_EQ(code_of(scratch_ / "a.STL"), ErrorCode{0});
  EXPECT_EQ(code_of(scratch_ / "a.xyz"), ErrorCode::usage);
  EXPECT_EQ(code_of(scratch_ / "noending"), ErrorCode::usage);
  EXPECT_EQ(code_of(scratch_ / "missing/a.vtp"), ErrorCode::refused);
  std::filesystem::create_directory(scratch_ / "folder.vtp");
  EXPECT_EQ(code_of(scratch_ / "folder.vtp"), ErrorCode::refused);
  EXPECT_THAT(scratch_.names(), ElementsAre("folder.vtp"));
  EXPECT_EQ(code_of("/proc/a.vtp"), ErrorCode::refused);
}

TEST_F(Surfaces, APipeIsNotReplaced) {
  ASSERT_EQ(mkfifo((scratch_ / "pipe.ply").c_str(), 0600), 0);
  std::filesystem::create_symlink("pipe.ply", scratch_ / "link.ply");
  for (const char* name : {"pipe.ply", "link.ply"}) {
    EXPECT_EQ(code_of(scratch_ / name), ErrorCode::refused) << name;
    EXPECT_THROW(write_file(scratch_ / name, "new"), Error) << name;
  }
  EXPECT_TRUE(std::filesystem::is_fifo(scratch_ / "pipe.ply"));
  EXPECT_THAT(scratch_.names(), ElementsAre("link.ply", "pipe.ply"));
}

TEST_F(Surfaces, LinksStayAndTheirFilesAreReplaced) {
  std::filesystem::create_directory(scratch_ / "folder");
  write("folder/a.ply", "old");
  std::filesystem::create_symlink("folder/a.ply", scratch_ / "a.ply");
  std::filesystem::create_symlink("a.ply", scratch_ / "b.ply");
  std::filesystem::create_symlink(scratch_ / "folder/new.ply", scratch_ / "new.ply");
  for (const char* name : {"b.ply", "new.ply"}) {
    write_file(scratch_ / name, name);
    EXPECT_TRUE(std::filesystem::is_symlink(scratch_ / name)) << name;
  }
  EXPECT_TRUE(std::filesystem::is_symlink(scratch_ / "a.ply"));
  EXPECT_EQ(read_text(scratch_ / "folder/a.ply"), "b.ply");
  EXPECT_EQ(read_text(scratch_ / "folder/new.ply"), "new.ply");
}

TEST_F(Surfaces, AFileThatIsReplacedLeavesItsPermissions) {
  for (const mode_t mode : {0600, 0640, 0444}) {
    chmod(write("a.ply", "old").c_str(), mode);
    write_file(scratch_ / "a.ply", "new");
    struct stat status;
    ASSERT_EQ(stat((scratch_ / "a.ply").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, mode);
    std::filesystem::remove(scratch_ / "a.ply");
  }
}

TEST_F(Surfaces, NamesAsLongAsTheSystemAllows) {
  const std::string longest = std::string(251, 'l') + ".ply", ending = "a." + std::string(253, 'l');
  for (const std::string& name : {longest, ending}) {
    check_writable(scratch_ / name);
    write_file(scratch_ / name, "new");
    EXPECT_EQ(read_text(scratch_ / name), "new");
  }
  EXPECT_EQ(code_of(scratch_ / "l" + longest), ErrorCode::refused);
}

TEST_F(Surfaces, AFullDiskLeavesTheOldFile) {
  const TriangleMesh mesh = random_mesh(5000);
  for (const char* name : kFormats) {
    SCOPED_TRACE(name);
    write(name, "old");
    {
      const FullDisk full(10'000);
      try {
        write_surface(scratch_ / name, mesh, Space::lps);
        ADD_FAILURE();
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::refused);
        EXPECT_THAT(error.what(), HasSubstr("make room"));
      }
    }
    EXPECT_EQ(read_text(scratch_ / name), "old");
  }
  EXPECT_EQ(scratch_.names().size(), std::size(kFormats));
}

TEST_F(Surfaces, AFileAppearsOnlyWhenItIsCommitted) {
  write("a.vtp", "old");
  {
    AtomicFile file(scratch_ / "a.vtp");
    write_text(file.temporary(), "half");
    EXPECT_EQ(std::filesystem::path(file.temporary()).parent_path().string() + "/", scratch_ / "");
    EXPECT_TRUE(file.temporary().ends_with(".vtp"));
    EXPECT_EQ(scratch_.names().size(), 2u);
  }
  EXPECT_EQ(read_text(scratch_ / "a.vtp"), "old");
  EXPECT_EQ(scratch_.names().size(), 1u);
  write_file(scratch_ / "a.vtp", "new");
  EXPECT_EQ(read_text(scratch_ / "a.vtp"), "new");
  EXPECT_EQ(scratch_.names().size(), 1u);
}

TEST_F(Surfaces, WhatIsCancelledIsNotCommitted) {
  write("a.vtp", "old");
  const std::atomic<bool> cancel{true};
  const auto expect_cancelled = [&](const auto& work) {
    try {
      work();
      ADD_FAILURE() << "it was written";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled);
      EXPECT_THAT(error.what(), HasSubstr("a.vtp was not written"));
    }
  };
  expect_cancelled([&] { write_file(scratch_ / "a.vtp", "new", &cancel); });
  expect_cancelled([&] { write_surface(scratch_ / "a.vtp", tetrahedron(), Space::lps, &cancel); });
  expect_cancelled(
      [&] { write_surface_map(scratch_ / "a.vtp", tetrahedron(), Space::lps, {}, {}, &cancel); });
  EXPECT_EQ(read_text(scratch_ / "a.vtp"), "old");
  EXPECT_THAT(scratch_.names(), ElementsAre("a.vtp"));
}

}  // namespace
}  // namespace vasamesh
