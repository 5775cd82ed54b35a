#include "libaccel/io/atomic_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

namespace fs = std::filesystem;

class AtomicFileTest : public FileTest {};

TEST_F(AtomicFileTest, AppearsAtCommit) {
  const fs::path target = folder() / "out.txt";
  Result<AtomicFile> out = AtomicFile::create(target);
  ASSERT_TRUE(out) << out.message();
  ASSERT_TRUE(out->write("one "));
  ASSERT_TRUE(out->write("two"));
  EXPECT_FALSE(fs::exists(target));
  ASSERT_TRUE(out->commit(AtomicFile::Durable::yes));
  EXPECT_EQ(contents(target), "one two");
  EXPECT_EQ(files_in_folder(), 1u);
}

TEST_F(AtomicFileTest, LeavesNothingWithoutCommit) {
  const fs::path target = file("out.txt", "before");
  {
    Result<AtomicFile> out = AtomicFile::create(target);
    ASSERT_TRUE(out);
    ASSERT_TRUE(out->write("after"));
    EXPECT_EQ(files_in_folder(), 2u);
  }
  EXPECT_EQ(contents(target), "before");
  EXPECT_EQ(files_in_folder(), 1u);
}

TEST_F(AtomicFileTest, MovedFromOwnsNothing) {
  Result<AtomicFile> first = AtomicFile::create(folder() / "a");
  ASSERT_TRUE(first);
  AtomicFile second = *std::move(first);
  ASSERT_TRUE(second.write("x"));
  Result<AtomicFile> third = AtomicFile::create(folder() / "b");
  ASSERT_TRUE(third);
  *third = std::move(second);  // what b would have been is dropped
  ASSERT_TRUE(third->commit());
  EXPECT_EQ(contents(folder() / "a"), "x");
  EXPECT_EQ(files_in_folder(), 1u);
}

TEST_F(AtomicFileTest, FollowsSymbolicLinks) {
  const fs::path target = file("real.txt", "before");
  fs::create_symlink(target, folder() / "link.txt");
  ASSERT_TRUE(write_file(folder() / "link.txt", "after"));
  EXPECT_TRUE(fs::is_symlink(folder() / "link.txt"));
  EXPECT_EQ(contents(target), "after");
}

TEST_F(AtomicFileTest, DevicesAreWrittenDirectly) {
  ASSERT_TRUE(write_file("/dev/null", "gone"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(AtomicFileTest, ErrorsNameTheTarget) {
  const Status missing = write_file(folder() / "no" / "such" / "folder.txt", "x");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.message().find("folder.txt"), std::string::npos) << missing.message();
  const Status directory = write_file(folder(), "x");
  ASSERT_FALSE(directory);
  EXPECT_NE(directory.message().find("is a folder"), std::string::npos);
}

TEST_F(AtomicFileTest, PathKeepsTheExtensionAndTheUsersMask) {
  const fs::path target = folder() / "picture.png";
  Result<AtomicPath> path = AtomicPath::create(target);
  ASSERT_TRUE(path);
  EXPECT_EQ(path->path().extension(), ".png");
  EXPECT_EQ(path->path().parent_path(), folder());
  file(path->path().filename().string(), "pixels");
  ASSERT_TRUE(path->commit());
  EXPECT_EQ(contents(target), "pixels");

  const mode_t mask = ::umask(0);
  ::umask(mask);
  struct stat status;
  ASSERT_EQ(::stat(target.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0666 & ~mask);
}

TEST_F(AtomicFileTest, KeepsTheModeOfWhatItReplaces) {
  const fs::path target = file("private.txt", "before");
  ASSERT_EQ(::chmod(target.c_str(), 0600), 0);
  ASSERT_TRUE(write_file(target, "after"));
  struct stat status;
  ASSERT_EQ(::stat(target.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

TEST_F(AtomicFileTest, ReadOnlyFilesAreNotReplaced) {
  const fs::path target = file("protected.txt", "before");
  ASSERT_EQ(::chmod(target.c_str(), 0444), 0);
  if (::access(target.c_str(), W_OK) == 0) GTEST_SKIP() << "this user may write read-only files";
  const Status status = write_file(target, "after");
  ASSERT_FALSE(status);
  EXPECT_NE(status.message().find("protected.txt"), std::string::npos) << status.message();
  EXPECT_EQ(contents(target), "before");
  EXPECT_EQ(files_in_folder(), 1u);
}

TEST_F(AtomicFileTest, LinksToNothingMakeTheirTarget) {
  std::filesystem::create_symlink("target", folder() / "link");
  std::filesystem::create_symlink("link", folder() / "other");
  ASSERT_TRUE(write_file(folder() / "other", "text"));
  EXPECT_EQ(contents(folder() / "target"), "text");
  EXPECT_TRUE(std::filesystem::is_symlink(folder() / "link"));
}

}  // namespace
}  // namespace accel
