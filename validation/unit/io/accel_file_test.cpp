#include "libaccel/io/accel_file.h"

#include <cstring>
#include <numeric>

#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

namespace fs = std::filesystem;

struct Two {
  float first, second;
};

class AccelFileTest : public FileTest {
 protected:
  void SetUp() override {
    FileTest::SetUp();
    std::iota(numbers_.begin(), numbers_.end(), 100u);
    path_ = folder() / "a.accel";
    AccelFileWriter writer;
    writer.add("numbers", std::span<const std::uint32_t>(numbers_));
    writer.add_text("text", "hello");
    writer.add("nothing", std::span<const double>());
    writer.add_value("pair", Two{1, 2});
    const Status written = writer.write(path_);
    ASSERT_TRUE(written) << written.message();
  }

  // Opens a file and takes every section. The first error, or an empty text.
  static std::string read_all(const fs::path& path) {
    const Result<AccelFile> file = AccelFile::open(path);
    if (!file) return file.message();
    if (const auto numbers = file->array<std::uint32_t>("numbers"); !numbers) return numbers.message();
    if (const auto text = file->text("text"); !text) return text.message();
    if (const auto nothing = file->array<double>("nothing"); !nothing) return nothing.message();
    if (const auto pair = file->value<Two>("pair"); !pair) return pair.message();
    return {};
  }

  std::vector<std::uint32_t> numbers_ = std::vector<std::uint32_t>(50);
  fs::path path_;
};

TEST_F(AccelFileTest, ComesBack) {
  const Result<AccelFile> file = AccelFile::open(path_);
  ASSERT_TRUE(file) << file.message();
  EXPECT_EQ(file->section_names(), (std::vector<std::string>{"numbers", "text", "nothing", "pair"}));
  EXPECT_EQ(file->count("numbers"), 50u);
  EXPECT_EQ(file->count("missing"), 0u);
  EXPECT_TRUE(file->has("nothing"));
  EXPECT_EQ(file->size_bytes(), fs::file_size(path_));

  const Result<Buffer<std::uint32_t>> numbers = file->array<std::uint32_t>("numbers");
  ASSERT_TRUE(numbers) << numbers.message();
  EXPECT_TRUE(std::equal(numbers->begin(), numbers->end(), numbers_.begin(), numbers_.end()));
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(numbers->data()) % kBufferAlignment, 0u);
  EXPECT_EQ(file->text("text").value(), "hello");
  EXPECT_TRUE(file->array<double>("nothing").value().empty());
  EXPECT_EQ(file->value<Two>("pair").value().second, 2);
}

TEST_F(AccelFileTest, ArraysOutliveTheFileAndCanBeChanged) {
  Buffer<std::uint32_t> numbers;
  {
    Result<AccelFile> file = AccelFile::open(path_);
    ASSERT_TRUE(file);
    numbers = file->array<std::uint32_t>("numbers").value();
  }
  numbers[7] = 1;
  EXPECT_EQ(numbers[7], 1u);
  EXPECT_EQ(read_all(path_), "");
}

TEST_F(AccelFileTest, SameInputSameBytes) {
  AccelFileWriter writer;
  writer.add_text("text", "hello");
  ASSERT_TRUE(writer.write(folder() / "b.accel"));
  ASSERT_TRUE(writer.write(folder() / "c.accel"));
  EXPECT_EQ(contents(folder() / "b.accel"), contents(folder() / "c.accel"));
}

TEST_F(AccelFileTest, WrongQuestions) {
  const Result<AccelFile> file = AccelFile::open(path_);
  ASSERT_TRUE(file);
  EXPECT_NE(file->array<int>("missing").message().find("a.accel: section 'missing' is missing"), std::string::npos);
  EXPECT_NE(file->array<double>("numbers").message().find("elements of 4 bytes instead of 8"), std::string::npos);
  EXPECT_NE(file->value<std::uint32_t>("numbers").message().find("50 elements instead of one"), std::string::npos);

  AccelFileWriter unnamed, long_name, twice;
  unnamed.add_text("", "x");
  long_name.add_text("a name of 24 characters!", "x");
  twice.add_text("x", "1"), twice.add_text("x", "2");
  EXPECT_FALSE(unnamed.write(folder() / "x"));
  EXPECT_FALSE(long_name.write(folder() / "x"));
  EXPECT_FALSE(twice.write(folder() / "x"));
  EXPECT_FALSE(fs::exists(folder() / "x"));
}

TEST_F(AccelFileTest, EveryChangedByteIsFound) {
  const std::string good = contents(path_);
  ASSERT_EQ(read_all(path_), "");
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (const int change : {0x10}) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ change);
      EXPECT_NE(read_all(file("bad.accel", bad)), "") << "byte " << i;
    }
  }
}

TEST_F(AccelFileTest, EveryTruncationIsFound) {
  const std::string good = contents(path_);
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_NE(read_all(file("bad.accel", good.substr(0, size))), "") << size;
  EXPECT_NE(read_all(file("bad.accel", good + std::string(64, '\0'))), "");
}

TEST_F(AccelFileTest, SectionsAreVerifiedWhenTaken) {
  std::string bad = contents(path_);
  bad[bad.size() - kBufferAlignment] ^= 1;  // in the last section
  const fs::path path = file("bad.accel", bad);
  const Result<AccelFile> strict = AccelFile::open(path), trusting = AccelFile::open(path, VerifyChecksums::no);
  ASSERT_TRUE(strict && trusting);
  EXPECT_TRUE(strict->array<std::uint32_t>("numbers"));
  const auto pair = strict->value<Two>("pair");
  ASSERT_FALSE(pair);
  EXPECT_NE(pair.message().find("bad.accel: section 'pair' is damaged"), std::string::npos) << pair.message();
  EXPECT_TRUE(trusting->value<Two>("pair"));
}

TEST_F(AccelFileTest, OtherFilesVersionsAndMachines) {
  const auto message = [&](std::size_t byte, std::string_view bytes) {
    std::string bad = contents(path_);
    bad.replace(byte, bytes.size(), bytes);
    return read_all(file("bad.accel", bad));
  };
  EXPECT_NE(message(0,
                    "\x7f"
                    "ELF")
                .find("is not a structure file"),
            std::string::npos);
  const char other_version = kAccelFileVersion + 1;
  EXPECT_NE(message(8, std::string_view(&other_version, 1)).find("another version"), std::string::npos);
  EXPECT_NE(message(12, std::string_view("\x01\x02\x03\x04", 4)).find("other byte order"), std::string::npos);
  EXPECT_NE(read_all(file("bad.accel", "")).find("is not a structure file"), std::string::npos);
  EXPECT_NE(read_all(folder() / "missing").find("No such file"), std::string::npos);
}

}  // namespace
}  // namespace accel
