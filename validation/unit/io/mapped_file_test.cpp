#include "libaccel/io/mapped_file.h"

#include <sys/stat.h>

#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

class MappedFileTest : public FileTest {};

TEST_F(MappedFileTest, HoldsTheBytes) {
  const Result<std::shared_ptr<MappedFile>> mapped = MappedFile::open(file("a", "hello"));
  ASSERT_TRUE(mapped) << mapped.message();
  const std::span<const std::byte> bytes = (*mapped)->bytes();
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()), "hello");
}

TEST_F(MappedFileTest, EmptyFile) {
  const Result<std::shared_ptr<MappedFile>> mapped = MappedFile::open(file("a", ""));
  ASSERT_TRUE(mapped);
  EXPECT_EQ((*mapped)->size(), 0u);
}

TEST_F(MappedFileTest, ChangesStayInMemory) {
  const std::filesystem::path path = file("a", "hello");
  const Result<std::shared_ptr<MappedFile>> mapped = MappedFile::open(path);
  ASSERT_TRUE(mapped);
  (*mapped)->data()[0] = std::byte{'j'};
  EXPECT_EQ((*mapped)->bytes()[0], std::byte{'j'});
  EXPECT_EQ(contents(path), "hello");
}

TEST_F(MappedFileTest, OnlyRegularFiles) {
  EXPECT_FALSE(MappedFile::open(folder() / "missing"));
  EXPECT_FALSE(MappedFile::open(folder()));
  EXPECT_FALSE(MappedFile::open("/dev/zero"));
  const std::filesystem::path pipe = folder() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto refused = MappedFile::open(pipe);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.message().find("pipe: is not a regular file"), std::string::npos) << refused.message();
}

}  // namespace
}  // namespace accel
