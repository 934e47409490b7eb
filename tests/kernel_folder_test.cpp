/// The folder of a driver's kernels: what is as recorded stays, all else goes.

#include "opencl/kernel_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "support/full_disk.h"
#include "support/scratch.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

class KernelFolders : public testing::Test {
 protected:
  /// As a driver leaves it: two kernels that are recorded, and a temporary file.
  void SetUp() override {
    const KernelFolder folder(path_);
    fs::create_directories(folder.files() / "program" / "kernel");
    write_text(kernel_, "built");
    write_text(other_, "");
    write_text(temporary_, "");
    folder.record();
  }
  /// What the next process finds.
  void reopen() const { const KernelFolder folder(path_); }

  Scratch scratch_;
  const std::string path_ = scratch_ / "made/for it";
  const std::string kernel_ = path_ + "/files/program/kernel/a name.so",
                    other_ = path_ + "/files/program/empty", temporary_ = path_ + "/files/temp_1";
};

std::string refusal(const std::string& path) {
  try {
    const KernelFolder folder(path);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::no_device);
    return error.what();
  }
  ADD_FAILURE() << "accepted";
  return "";
}

TEST_F(KernelFolders, RecordedFilesStayAndTemporaryOnesGo) {
  for (int processes = 0; processes < 2; ++processes) {
    reopen();
    EXPECT_EQ(read_text(kernel_), "built");
    EXPECT_TRUE(fs::exists(other_));
    EXPECT_FALSE(fs::exists(temporary_));
  }
}

TEST_F(KernelFolders, ChangedFilesGo) {
  for (const char* content : {"buil", "", "bUilt", "built\n"}) {
    SetUp();
    write_text(kernel_, content);
    reopen();
    EXPECT_FALSE(fs::exists(kernel_)) << content;
    EXPECT_TRUE(fs::exists(other_)) << content;
  }
}

TEST_F(KernelFolders, WhatIsNoFileGoes) {
  fs::rename(kernel_, scratch_ / "elsewhere");
  fs::create_symlink(scratch_ / "elsewhere", kernel_);
  fs::create_directory_symlink(scratch_ / "", path_ + "/files/program/link");
  reopen();
  EXPECT_FALSE(fs::is_symlink(kernel_));
  EXPECT_FALSE(fs::is_symlink(path_ + "/files/program/link"));
  EXPECT_TRUE(fs::exists(scratch_ / "elsewhere"));
}

TEST_F(KernelFolders, OfAProcessThatWasKilledNothingStays) {
  write_text(path_ + "/files/program/kernel/half.so", "bui");
  reopen();
  EXPECT_FALSE(fs::exists(path_ + "/files/program/kernel/half.so"));
  EXPECT_TRUE(fs::exists(kernel_));
}

TEST_F(KernelFolders, WithoutItsRecordNothingStays) {
  for (const auto& entry : fs::directory_iterator(path_))
    if (entry.path().extension() == ".clbin") write_text(entry.path(), "no record");
  reopen();
  EXPECT_FALSE(fs::exists(kernel_));
  EXPECT_FALSE(fs::exists(other_));
}

TEST_F(KernelFolders, DamageIsNotRecordedLater) {
  std::optional<KernelFolder> folder(path_);
  write_text(kernel_, "bUilt");
  folder->record();
  folder.reset();
  reopen();
  EXPECT_FALSE(fs::exists(kernel_));
}

TEST_F(KernelFolders, NothingGoesWhileAnotherIsAtWork) {
  std::optional<KernelFolder> folder(path_);
  write_text(path_ + "/files/program/kernel/new.so", "new");
  write_text(temporary_, "");
  reopen();
  EXPECT_TRUE(fs::exists(path_ + "/files/program/kernel/new.so"));
  EXPECT_TRUE(fs::exists(temporary_));
  folder.reset();
  reopen();
  EXPECT_FALSE(fs::exists(path_ + "/files/program/kernel/new.so"));
}

TEST_F(KernelFolders, TooLargeAFolderIsEmptied) {
  {
    const KernelFolder folder(path_);
    write_text(path_ + "/files/program/large", "");
    fs::resize_file(path_ + "/files/program/large", std::uintmax_t{33} << 20);
    folder.record();
  }
  reopen();
  EXPECT_FALSE(fs::exists(path_ + "/files/program/large"));
  EXPECT_FALSE(fs::exists(kernel_));
}

TEST_F(KernelFolders, FoldersThatCannotBeUsed) {
  EXPECT_THAT(refusal(kernel_ + "/below"), HasSubstr("cannot be made"));
  EXPECT_THAT(refusal("/proc/vasamesh"), HasSubstr("cannot be made"));
  fs::remove(path_ + "/lock");
  fs::create_directory(path_ + "/lock");
  EXPECT_THAT(refusal(path_), HasSubstr("cannot be written"));
  fs::remove(path_ + "/lock");
  const FullDisk full(100000);
  EXPECT_THAT(refusal(path_), HasSubstr("has room for 97 kB, not for 32768 kB"));
}

}  // namespace
}  // namespace vasamesh
