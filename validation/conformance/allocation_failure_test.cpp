// What happens where memory ends: every allocation of an operation fails once, by itself or with all that follow it. Then the
// operation must return an error (or manage without), throw nothing, leak nothing, neither memory nor files nor mappings, and
// leave of a file that it writes what was there before.
//
// Failing are the allocations by operator new, in all its forms, which this program replaces. Exempt are those that C libraries
// make by malloc, oneTBB's of tasks and arenas and zstd's of windows, and the list of methods, which is made once and stays.
// Left out is what goes through nlohmann-json 3.11, glTF, scene descriptions and metadata: its values allocate when they are
// destroyed, so that the program ends where that fails, and values that are half made leak.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <limits>
#include <new>

#include "libaccel/io/atomic_file.h"
#include "libaccel/io/load_mesh.h"
#include "libaccel/io/npy.h"
#include "libaccel/io/structure_sections.h"
#include "libaccel/packet/ray_order.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/registry/structures.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"
#include "validation/unit/io/io_test_support.h"

namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max() / 2;

std::atomic<std::int64_t> live_blocks{0};
std::atomic<std::int64_t> until_failure{kNever};
std::atomic<bool> all_that_follow{false};

bool fails_now() {
  const std::int64_t left = until_failure.fetch_sub(1, std::memory_order_relaxed);
  return left == 0 || (left < 0 && all_that_follow.load(std::memory_order_relaxed));
}

void* allocate(std::size_t size, std::size_t alignment) {
  if (fails_now()) throw std::bad_alloc();
  void* block = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment + alignment);
  if (block == nullptr) throw std::bad_alloc();
  live_blocks.fetch_add(1, std::memory_order_relaxed);
  return block;
}

void release(void* block) {
  if (block != nullptr) live_blocks.fetch_sub(1, std::memory_order_relaxed);
  std::free(block);
}

}  // namespace

// Arrays and the forms that return null come to these.
void* operator new(std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) { return allocate(size, static_cast<std::size_t>(alignment)); }
void* operator new[](std::size_t size) { return operator new(size); }
void* operator new[](std::size_t size, std::align_val_t alignment) { return operator new(size, alignment); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  try {
    return operator new(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* block) noexcept { release(block); }
void operator delete(void* block, std::size_t) noexcept { release(block); }
void operator delete(void* block, std::align_val_t) noexcept { release(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { release(block); }
void operator delete(void* block, const std::nothrow_t&) noexcept { release(block); }
void operator delete[](void* block) noexcept { release(block); }
void operator delete[](void* block, std::size_t) noexcept { release(block); }
void operator delete[](void* block, std::align_val_t) noexcept { release(block); }
void operator delete[](void* block, std::size_t, std::align_val_t) noexcept { release(block); }

namespace accel::validation {
namespace {

namespace fs = std::filesystem;

enum class Threw { no, yes };

class AllocationFailure : public FileTest {
 protected:
  // Runs work(), which returns whether it succeeded, with the n-th allocation failing, for every n that it comes to. after()
  // checks what must hold behind each run.
  template <class Work, class After>
  static void fail_each(const std::string& what, const Work& work, const After& after) {
    ASSERT_TRUE(work()) << what << ": fails where nothing does; also makes what stays for good";
    for (const bool all : {false, true}) {
      bool reached = true;
      for (std::int64_t n = 0; reached; ++n) {
        const Outcome outcome = run(work, n, all, reached);
        const std::string where = what + ", allocation " + std::to_string(n) + (all ? " and all that follow" : "");
        ASSERT_EQ(outcome.threw, Threw::no) << where;
        ASSERT_EQ(outcome.leaked, 0) << where;
        ASSERT_TRUE(outcome.succeeded || reached) << where;
        after(where);
      }
    }
  }
  template <class Work>
  static void fail_each(const std::string& what, const Work& work) {
    fail_each(what, work, [](const std::string&) {});
  }

  // The descriptors of this process, and the mappings of files in the test's folder.
  static std::size_t descriptors() {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), {}));
  }
  std::size_t mappings() const {
    std::ifstream maps("/proc/self/maps");
    std::size_t count = 0;
    for (std::string line; std::getline(maps, line);) count += line.find(folder().string()) != std::string::npos;
    return count;
  }

  // Reading, and that nothing stays open.
  template <class Read>
  void fail_reading(const std::string& what, const Read& read) {
    const std::size_t open = descriptors(), mapped = mappings();
    fail_each(
        what, [&] { return read().ok(); },
        [&](const std::string& where) {
          ASSERT_EQ(descriptors(), open) << where;
          ASSERT_EQ(mappings(), mapped) << where;
        });
  }

  // Writing: the target holds what it did or what it shall, and nothing else is left in its folder.
  template <class Write>
  void fail_writing(const std::string& what, const Write& write) {
    const fs::path target = folder() / "target";
    ASSERT_TRUE(write(target).ok());
    const std::string whole = contents(target);
    const std::size_t open = descriptors(), files = files_in_folder();
    fail_each(
        what, [&] { return write(target).ok(); },
        [&](const std::string& where) {
          const std::string now = contents(target);
          ASSERT_TRUE(now == "old" || now == whole) << where;
          ASSERT_EQ(files_in_folder(), files) << where;
          ASSERT_EQ(descriptors(), open) << where;
          std::ofstream(target) << "old";
        });
  }

 private:
  struct Outcome {
    bool succeeded;
    Threw threw;
    std::int64_t leaked;
  };

  template <class Work>
  static Outcome run(const Work& work, std::int64_t n, bool all, bool& reached) {
    Outcome outcome{false, Threw::no, 0};
    const std::int64_t live = live_blocks;
    all_that_follow = all;
    until_failure = n;
    try {
      outcome.succeeded = work();
    } catch (...) {
      outcome.threw = Threw::yes;
    }
    reached = until_failure < 0;
    all_that_follow = false;
    until_failure = kNever;
    outcome.leaked = live_blocks - live;
    return outcome;
  }
};

TriangleMesh small_mesh() { return mesh_of(random_triangles(24, 0.5f, 1)); }

constexpr char kObj[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv .2 .1 0\nv 0 1 0\nf 1 2 3 4 5\nf 1 2 3\n";
constexpr char kPly[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2\n";

TEST_F(AllocationFailure, LoadingMeshes) {
  const fs::path obj = file("a.obj", kObj), ply = file("a.ply", kPly);
  fail_reading("OBJ", [&] { return load_mesh(obj); });
  fail_reading("PLY", [&] { return load_mesh(ply); });
}

TEST_F(AllocationFailure, ReadingArrays) {
  const fs::path rays = folder() / "rays.npy", hits = folder() / "hits.npy";
  ASSERT_TRUE(write_rays_npy(rays, std::vector<Ray>(3)));
  ASSERT_TRUE(write_hits_npy(hits, std::vector<Hit>(3)));
  fail_reading("rays", [&] { return read_rays_npy(rays); });
  fail_reading("hits", [&] { return read_hits_npy(hits); });
}

// One method a structure is enough: files hold structures.
TEST_F(AllocationFailure, WritingAndReadingStructures) {
  const TriangleMesh mesh = small_mesh();
  std::string last;
  for (const MethodInfo& method : methods()) {
    if (std::exchange(last, method.structure) == method.structure) continue;
    const auto accel = AnyAccel::build(mesh, method.name, {.threads = 1});
    ASSERT_TRUE(accel) << accel.message();
    const auto scene = InstancedMeshes::make({mesh}, {Instance{}});
    visit_structure(accel->structure(), [&]<class Structure>(const Structure& structure) {
      const auto write = [&](const fs::path& path) -> Status {
        try {  // as save_accel() does
          AccelFileWriter writer;
          method.instances ? write_sections(writer, *scene) : write_sections(writer, mesh);
          write_sections(writer, structure);
          return writer.write(path);
        } catch (const std::bad_alloc&) {
          return Error{"no memory"};
        }
      };
      fail_writing("writing " + method.structure, write);
      const fs::path path = folder() / "structure";
      EXPECT_TRUE(write(path));
      fail_reading("reading " + method.structure, [&]() -> Status {
        const auto opened = AccelFile::open(path);
        if (!opened) return opened.error();
        const auto facts = read<MeshFacts>(*opened);
        if (!facts) return facts.error();
        const auto back = read<Structure>(*opened);
        return back ? Status(Done{}) : back.error();
      });
      return true;
    });
  }
}

TEST_F(AllocationFailure, WritingArraysAndText) {
  const std::vector<Ray> rays(3);
  const std::vector<Hit> hits(4);
  fail_writing("rays", [&](const fs::path& path) { return write_rays_npy(path, rays); });
  fail_writing("hits", [&](const fs::path& path) { return write_hits_npy(path, hits); });
  fail_writing("hits of several", [&](const fs::path& path) { return write_hits_npy(path, hits, 2); });
  fail_writing("text", [&](const fs::path& path) { return write_file(path, "a text"); });
}

TEST_F(AllocationFailure, MakingRays) {
  const TriangleMesh mesh = small_mesh();
  const Aabb box = mesh_facts(mesh).bounds;
  const Camera camera = *Camera::make(default_camera(box), 8, 6);
  const RaySet primary = *primary_rays(camera, 2);
  const std::vector<Hit> hits(primary.size(), Hit{1, 0.25f, 0.25f, 3});
  const PrimaryHits from{mesh, primary, hits};
  for (const PixelOrder order : {PixelOrder::rows, PixelOrder::z_curve})
    fail_each("primary", [&] { return primary_rays(camera, 2, 1, order).ok(); });
  for (const RayKind kind : {RayKind::shadow, RayKind::soft_shadow, RayKind::diffuse, RayKind::ao})
    fail_each("secondary", [&] { return secondary_rays(kind, from, {}).ok(); });
  fail_each("random", [&] { return random_rays(box, 50).ok(); });
  fail_each("edge", [&] { return edge_rays(mesh, 50).ok(); });
  for (const RaySort sort : kRaySorts)
    fail_each("sorting", [&] { return order_rays(primary.rays.span(), box, {.sort = sort, .threads = 1}).ok(); });
}

TEST_F(AllocationFailure, Building) {
  const TriangleMesh mesh = small_mesh();
  for (const MethodInfo& method : methods())
    fail_each(method.name, [&] { return AnyAccel::build(mesh, method.name, {.threads = 1}).ok(); });
}

// A scene keeps the mesh that it is flattened to: that is made where nothing fails.
TEST_F(AllocationFailure, BuildingInstances) {
  const auto scene = InstancedMeshes::make({small_mesh()}, {Instance{}, Instance{}});
  ASSERT_TRUE(scene) << scene.message();
  ASSERT_TRUE(scene->flattened());
  for (const char* method : {"instances/stack", "instances/hash", "bvh8-instances/stream", "bvh8/ordered"})
    fail_each(method, [&] { return AnyAccel::build(*scene, method, {.threads = 1}).ok(); });
}

// From each method to all others of its builder.
TEST_F(AllocationFailure, Annotating) {
  const TriangleMesh mesh = small_mesh();
  for (const MethodInfo& from : methods()) {
    const auto accel = AnyAccel::build(mesh, from.name, {.threads = 1});
    ASSERT_TRUE(accel) << accel.message();
    for (const MethodInfo& to : methods())
      if (to.builder == from.builder && &to != &from)
        fail_each(from.name + " as " + to.name, [&] { return AnyAccel::bind(accel->structure(), to.name).ok(); });
  }
}

TEST_F(AllocationFailure, Tracing) {
  const TriangleMesh mesh = small_mesh();
  const std::vector<Ray> rays = stress_rays(mesh, 40);
  std::vector<Hit> hits(rays.size()), several(3 * rays.size());
  std::vector<std::uint8_t> occluded(rays.size());
  std::vector<std::uint32_t> counts(rays.size());
  const TraceOptions options{.threads = 1};
  for (const MethodInfo& method : methods()) {
    const auto accel = AnyAccel::build(mesh, method.name, {.threads = 1});
    ASSERT_TRUE(accel) << accel.message();
    fail_each(method.name + " closest", [&] { return accel->closest(rays, hits, options).ok(); });
    fail_each(method.name + " occluded", [&] { return accel->occluded(rays, occluded, options).ok(); });
    fail_each(method.name + " k_nearest", [&] { return accel->k_nearest(rays, 3, several, counts, options).ok(); });
    fail_each(method.name + " next_hits", [&] { return accel->next_hits(rays, hits, 3, several, counts, options).ok(); });
    fail_each(method.name + " count", [&] { return accel->count(rays, Query::closest, counts, options).ok(); });
    fail_each(method.name + " simt", [&] { return accel->profile_simt(rays, Query::closest, hits, {}, options).ok(); });
    fail_each(method.name + " multipass", [&] { return accel->trace_multipass(rays, Query::any, hits, {}, options).ok(); });
  }
}

}  // namespace
}  // namespace accel::validation
