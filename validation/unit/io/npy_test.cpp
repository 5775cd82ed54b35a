#include "libaccel/io/npy.h"

#include <cmath>
#include <cstring>
#include <random>

#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

class NpyTest : public FileTest {
 protected:
  // A .npy file of a given header and data.
  std::filesystem::path npy(std::string dict, std::string_view data, int version = 1) const {
    std::string bytes = std::string("\x93NUMPY") + static_cast<char>(version) + '\0';
    const std::uint32_t length = static_cast<std::uint32_t>(dict.size());
    bytes.append(reinterpret_cast<const char*>(&length), version == 1 ? 2 : 4);
    return file("array.npy", bytes + dict + std::string(data));
  }

  template <class T>
  static std::string raw(const std::vector<T>& values, bool swap = false) {
    std::string bytes;
    for (const T value : values) {
      char number[sizeof(T)];
      std::memcpy(number, &value, sizeof(T));
      if (swap) std::reverse(number, number + sizeof(T));
      bytes.append(number, sizeof(T));
    }
    return bytes;
  }

  void expect_error(const std::filesystem::path& path, std::string_view part) const {
    const Result<Buffer<Ray>> rays = read_rays_npy(path);
    ASSERT_FALSE(rays);
    EXPECT_NE(rays.message().find(part), std::string::npos) << rays.message();
    EXPECT_NE(rays.message().find("array.npy"), std::string::npos) << rays.message();
  }
};

TEST_F(NpyTest, RaysComeBackBitForBit) {
  std::mt19937 random(3);
  std::vector<Ray> rays(1000);
  for (Ray& ray : rays) {
    std::uint32_t words[8];
    for (std::uint32_t& word : words) word = static_cast<std::uint32_t>(random());
    std::memcpy(static_cast<void*>(&ray), words, sizeof(ray));
  }
  const std::filesystem::path path = folder() / "rays.npy";
  ASSERT_TRUE(write_rays_npy(path, rays));
  const Result<Buffer<Ray>> back = read_rays_npy(path);
  ASSERT_TRUE(back) << back.message();
  ASSERT_EQ(back->size(), rays.size());
  EXPECT_EQ(std::memcmp(back->data(), rays.data(), back->size_bytes()), 0);

  const std::string bytes = contents(path);
  EXPECT_EQ((bytes.size() - rays.size() * sizeof(Ray)) % 64, 0u);
  EXPECT_NE(bytes.find("{'descr': '<f4', 'fortran_order': False, 'shape': (1000, 8), }"), std::string::npos);
}

TEST_F(NpyTest, CountsWithoutReading) {
  const std::filesystem::path path = folder() / "rays.npy";
  ASSERT_TRUE(write_rays_npy(path, std::vector<Ray>(7)));
  EXPECT_EQ(*count_rays_npy(path), 7u);
  EXPECT_FALSE(count_rays_npy(folder() / "none.npy"));
  ASSERT_TRUE(write_hits_npy(path, std::vector<Hit>(7)));
  EXPECT_FALSE(count_rays_npy(path));
}

TEST_F(NpyTest, HitsComeBack) {
  const std::vector<Hit> hits = {{1.5f, 0.25f, 0.5f, 7}, {}};
  const std::filesystem::path path = folder() / "hits.npy";
  ASSERT_TRUE(write_hits_npy(path, hits));
  const Result<Buffer<Hit>> back = read_hits_npy(path);
  ASSERT_TRUE(back) << back.message();
  ASSERT_EQ(back->size(), 2u);
  EXPECT_EQ(std::memcmp(back->data(), hits.data(), sizeof(Hit) * 2), 0);
  EXPECT_FALSE(read_rays_npy(path));
}

TEST_F(NpyTest, SeveralHitsARayAreRows) {
  const std::vector<Hit> hits(6, Hit{1.5f, 0.25f, 0.5f, 7});
  const std::filesystem::path path = folder() / "hits.npy";
  ASSERT_TRUE(write_hits_npy(path, hits, 3));
  const std::string bytes = contents(path);
  EXPECT_NE(bytes.find("'shape': (2, 3), }"), std::string::npos);
  EXPECT_EQ(bytes.compare(bytes.size() - 96, 96, reinterpret_cast<const char*>(hits.data()), 96), 0);
  EXPECT_FALSE(read_hits_npy(path)) << "one hit a ray is what is read";
  EXPECT_FALSE(write_hits_npy(path, hits, 4)) << "no rows";
  EXPECT_FALSE(write_hits_npy(path, hits, 0));
  EXPECT_EQ(contents(path), bytes) << "what was there stays";
  ASSERT_TRUE(write_hits_npy(path, {}, 3));
  EXPECT_NE(contents(path).find("'shape': (0, 3), }"), std::string::npos);
}

TEST_F(NpyTest, EmptyArrays) {
  ASSERT_TRUE(write_rays_npy(folder() / "r.npy", {}));
  EXPECT_EQ(read_rays_npy(folder() / "r.npy").value().size(), 0u);
  ASSERT_TRUE(write_hits_npy(folder() / "h.npy", {}));
  EXPECT_EQ(read_hits_npy(folder() / "h.npy").value().size(), 0u);
}

TEST_F(NpyTest, SixColumnsAreWholeHalfLines) {
  const auto rays =
      read_rays_npy(npy("{'descr': '<f4', 'fortran_order': False, 'shape': (1, 6), }", raw<float>({1, 2, 3, 4, 5, 6})));
  ASSERT_TRUE(rays) << rays.message();
  EXPECT_EQ((*rays)[0].org, (Vec3{1, 2, 3}));
  EXPECT_EQ((*rays)[0].dir, (Vec3{4, 5, 6}));
  EXPECT_EQ((*rays)[0].t_min, 0);
  EXPECT_TRUE(std::isinf((*rays)[0].t_max));
}

TEST_F(NpyTest, DoubleBigEndianFortranAndNewVersions) {
  const std::vector<double> by_column = {1, 7, 2, 8, 3, 9, 4, 10, 5, 11, 6, 12};
  for (const int version : {1, 2, 3}) {
    for (const bool big : {false, true}) {
      const std::string type = big ? ">f8" : "<f8";
      const auto rays =
          read_rays_npy(npy("{\"shape\":(2,6),'fortran_order':True,'descr':'" + type + "'}\n", raw(by_column, big), version));
      ASSERT_TRUE(rays) << rays.message();
      EXPECT_EQ((*rays)[1].org, (Vec3{7, 8, 9}));
      EXPECT_EQ((*rays)[1].dir, (Vec3{10, 11, 12}));
    }
  }
}

TEST_F(NpyTest, Errors) {
  const std::string good = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 6), }", data(24, '\0');
  expect_error(file("array.npy", ""), "not a .npy file");
  expect_error(file("array.npy", "hello, this is no array at all"), "not a .npy file");
  expect_error(npy(good, data, 9), "version 9.0");
  expect_error(npy(good, data.substr(1)), "truncated");
  expect_error(npy(good, data + "x"), "does not fit");
  expect_error(npy("{'descr': '<i4', 'fortran_order': False, 'shape': (1, 6), }", data), "float32 or float64");
  expect_error(npy("{'descr': '<f4', 'fortran_order': False, 'shape': (6,), }", data), "(6,)");
  expect_error(npy("{'descr': '<f4', 'fortran_order': False, 'shape': (1, 7), }", data), "(1, 7)");
  expect_error(npy("{'descr': '<f4', 'fortran_order': False, 'shape': (18446744073709551615, 6), }", data), "does not fit");
  expect_error(npy("{'descr': '<f4', 'fortran_order': False, 'shape': (768614336404564651, 6), }", data), "does not fit");
  expect_error(npy("{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999, 6), }", data), "damaged");
  expect_error(npy("{'descr': '<f4', 'fortran_order': Maybe, 'shape': (1, 6), }", data), "damaged");
  expect_error(npy("{'descr': '<f4', 'shape': (1, 6), }", data), "damaged");
  expect_error(npy("{'descr': '<f4', 'descr': '<f4', 'fortran_order': False, 'shape': (1, 6)}", data), "damaged");
  expect_error(npy(good + good, data), "damaged");
}

// No header, however broken, causes more than an error.
TEST_F(NpyTest, EveryByteOfTheHeaderMayBeWrong) {
  const std::filesystem::path path = folder() / "hits.npy";
  ASSERT_TRUE(write_hits_npy(path, std::vector<Hit>(2)));
  const std::string good = contents(path);
  for (std::size_t i = 0; i + 2 * sizeof(Hit) < good.size(); ++i) {
    for (const char value : {'\0', '(', '\'', '\xff', '9'}) {
      std::string bad = good;
      bad[i] = value;
      const Result<Buffer<Hit>> hits = read_hits_npy(file("bad.npy", bad));
      EXPECT_TRUE(!hits || hits->size() == 2);
    }
  }
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(read_hits_npy(file("short.npy", good.substr(0, size)))) << size;
}

}  // namespace
}  // namespace accel
