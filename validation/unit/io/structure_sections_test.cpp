#include "libaccel/io/structure_sections.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "libaccel/build/binned_sah.h"
#include "libaccel/build/grid.h"
#include "libaccel/build/instances.h"
#include "libaccel/build/kdtree_links.h"
#include "libaccel/build/kdtree_ropes.h"
#include "libaccel/build/kdtree_sah.h"
#include "libaccel/structure/triangle_list.h"
#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

namespace fs = std::filesystem;

template <class T>
bool same(const Buffer<T>& a, const Buffer<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

TriangleMesh grid_mesh(int n) {
  TriangleMesh mesh{Buffer<Vec3>(n * n), Buffer<IndexTriple>(2 * (n - 1) * (n - 1))};
  const auto vertex = [n](int x, int y) { return static_cast<std::uint32_t>(y * n + x); };
  std::size_t triangle = 0;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) mesh.vertices[vertex(x, y)] = {float(x), float(y), std::sin(float(x * y))};
  for (int y = 0; y + 1 < n; ++y)
    for (int x = 0; x + 1 < n; ++x) {
      mesh.triangles[triangle++] = {vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1)};
      mesh.triangles[triangle++] = {vertex(x, y), vertex(x + 1, y + 1), vertex(x, y + 1)};
    }
  return mesh;
}

class StructureSectionsTest : public FileTest {
 protected:
  static Bvh2 build(const TriangleMesh& mesh) { return BinnedSah::build(mesh, {}).value().structure; }
  fs::path path() const { return folder() / "a.accel"; }
};

TEST_F(StructureSectionsTest, InstancesComeBack) {
  const Affine there{{{0, 0, 1, 5}, {0, -2, 0, 6}, {1, 0, 0, 7}}};
  const auto scene =
      InstancedMeshes::make({grid_mesh(5), grid_mesh(1), grid_mesh(3)}, {{2, {}}, {0, there}, {1, {}}, {2, there}});
  ASSERT_TRUE(scene) << scene.message();
  const auto built = InstanceBuilder::build(*scene, {});
  ASSERT_TRUE(built) << built.message();
  ASSERT_TRUE(save_accel(path(), {}, *scene, built->structure));

  const Result<AccelFile> file = AccelFile::open(path());
  ASSERT_TRUE(file) << file.message();
  EXPECT_TRUE(has_instances(*file));
  EXPECT_EQ(triangle_count(*file), scene->size());
  const auto back = read<InstancedMeshes>(*file);
  ASSERT_TRUE(back) << back.message();
  ASSERT_EQ(back->instances().size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(back->instances()[i].mesh, scene->instances()[i].mesh);
    EXPECT_EQ(back->instances()[i].transform, scene->instances()[i].transform);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(same(back->meshes()[i].vertices, scene->meshes()[i].vertices));
    EXPECT_TRUE(same(back->meshes()[i].triangles, scene->meshes()[i].triangles));
  }
  const auto mesh = read<TriangleMesh>(*file);
  ASSERT_FALSE(mesh);
  EXPECT_NE(mesh.message().find("holds a scene of instances"), std::string::npos);
  EXPECT_EQ(read<AccelMetadata>(*file)->structure, TwoLevelBvh::kName) << "it is what it is, whatever the caller said";
  const auto structure = read<TwoLevelBvh>(*file);
  ASSERT_TRUE(structure) << structure.message();
  EXPECT_TRUE(same(structure->nodes, built->structure.nodes));
  EXPECT_TRUE(same(structure->trees, built->structure.trees));
  EXPECT_TRUE(same(structure->instances, built->structure.instances));
}

TEST_F(StructureSectionsTest, DamagedInstancesAreErrors) {
  const TriangleMesh mesh = grid_mesh(3);
  const auto complaint = [&](std::vector<std::uint64_t> meshes, std::vector<Instance> instances) {
    AccelFileWriter writer;
    write_sections(writer, mesh);
    struct Part {
      std::uint64_t vertices, triangles;
    };
    std::vector<Part> parts;
    for (std::size_t i = 0; i < meshes.size(); i += 2) parts.push_back({meshes[i], meshes[i + 1]});
    writer.add_copy<Part>("scene.meshes", parts);
    writer.add_copy<Instance>("scene.instances", instances);
    EXPECT_TRUE(writer.write(path()));
    const auto scene = read<InstancedMeshes>(*AccelFile::open(path()));
    return scene ? std::string() : scene.message();
  };
  Affine singular;
  singular.m[0][0] = 0;
  EXPECT_EQ(complaint({9, 8}, {{0, {}}}), "");
  EXPECT_NE(complaint({9, 9}, {{0, {}}}), "");
  EXPECT_NE(complaint({~std::uint64_t{0}, 8}, {{0, {}}}), "");
  EXPECT_NE(complaint({8, 8}, {{0, {}}}), "") << "a triangle names the ninth vertex";
  EXPECT_NE(complaint({9, 8}, {{1, {}}}), "");
  EXPECT_NE(complaint({9, 8}, {{0, singular}}), "");
}

TEST_F(StructureSectionsTest, MetadataComesBack) {
  AccelMetadata metadata{"bvh2", "bvh", "sc\xe8ne \"a\".ply", {{"bins", "32"}}, {{"sah_cost", 1.0 / 3}, {"epo", NAN}}, {}, {}};
  metadata.cameras.push_back({{0.1f, 2, 3}, {4, 5, 6}, {0, 1, 0}, 39.5f, "door"});
  metadata.light = LightDescription{{1, 2, 3}, {0.1f, 0, 0}, {0, 1e-30f, 0}};
  AccelFileWriter writer;
  write_sections(writer, metadata);
  ASSERT_TRUE(writer.write(path()));
  const Result<AccelFile> file = AccelFile::open(path());
  ASSERT_TRUE(file) << file.message();
  const Result<AccelMetadata> back = read<AccelMetadata>(*file);
  ASSERT_TRUE(back) << back.message();
  EXPECT_EQ(back->structure, "bvh2");
  EXPECT_EQ(back->builder, "bvh");
  EXPECT_EQ(back->options, metadata.options);
  EXPECT_EQ(back->statistics.at("sah_cost"), 1.0 / 3);
  EXPECT_TRUE(std::isnan(back->statistics.at("epo")));
  ASSERT_EQ(back->cameras.size(), 1u);
  EXPECT_EQ(back->cameras[0].name, "door");
  EXPECT_EQ(back->cameras[0].eye, (Vec3{0.1f, 2, 3}));
  EXPECT_EQ(back->cameras[0].vfov_degrees, 39.5f);
  ASSERT_TRUE(back->light);
  EXPECT_EQ(back->light->half_v, (Vec3{0, 1e-30f, 0}));
}

// Of a file with good checksums, which anyone can make: as deep as no stack is.
TEST_F(StructureSectionsTest, MetadataNestedDeepIsAnError) {
  for (const std::size_t depth : {10u, 1'000'000u}) {
    AccelFileWriter writer;
    writer.add_text("metadata",
                    R"({"structure": "bvh2", "builder": "", "scene": "", "options": {}, "statistics": {}, "view": )" +
                        std::string(depth, '[') + std::string(depth, ']') + "}");
    ASSERT_TRUE(writer.write(path()));
    const Result<AccelFile> file = AccelFile::open(path());
    ASSERT_TRUE(file) << file.message();
    EXPECT_FALSE(read<AccelMetadata>(*file)) << depth;
  }
}

TEST_F(StructureSectionsTest, Bvh2ComesBack) {
  const TriangleMesh mesh = grid_mesh(20);
  const Bvh2 bvh = build(mesh);
  ASSERT_TRUE(save_accel(path(), {}, mesh, bvh));
  const Result<AccelFile> file = AccelFile::open(path());
  ASSERT_TRUE(file) << file.message();
  EXPECT_EQ(triangle_count(*file), mesh.size());
  const Result<Bvh2> back = read<Bvh2>(*file);
  ASSERT_TRUE(back) << back.message();
  EXPECT_TRUE(same(back->nodes, bvh.nodes));
  EXPECT_TRUE(same(back->leaves, bvh.leaves));
  EXPECT_EQ(back->root, bvh.root);
  EXPECT_EQ(back->depth, bvh.depth);
  EXPECT_EQ(back->references, bvh.references);
  const Result<TriangleMesh> back_mesh = read<TriangleMesh>(*file);
  ASSERT_TRUE(back_mesh) << back_mesh.message();
  EXPECT_TRUE(same(back_mesh->vertices, mesh.vertices));
  EXPECT_TRUE(same(back_mesh->triangles, mesh.triangles));
  EXPECT_FALSE(read<TriangleList>(*file));
}

// A file whose mesh is damaged shows who touches it: reading facts and structures does not.
TEST_F(StructureSectionsTest, OnlyReadingTheMeshTouchesIt) {
  TriangleMesh mesh = grid_mesh(20);
  mesh.triangles[7] = {1, 1, 2};
  const Bvh2 bvh = build(mesh);
  ASSERT_TRUE(save_accel(path(), {}, mesh, bvh));
  std::string bytes = contents(path());
  for (const auto& array : {std::as_bytes(mesh.vertices.span()), std::as_bytes(mesh.triangles.span())}) {
    const std::size_t at = bytes.find({reinterpret_cast<const char*>(array.data()), array.size()});
    ASSERT_NE(at, std::string::npos);
    bytes[at] ^= 1;
  }
  file("a.accel", bytes);

  const Result<AccelFile> file = AccelFile::open(path());
  ASSERT_TRUE(file) << file.message();
  EXPECT_EQ(triangle_count(*file), mesh.size());
  EXPECT_TRUE(read<AccelMetadata>(*file));
  EXPECT_TRUE(read<Bvh2>(*file));
  const Result<MeshFacts> facts = read<MeshFacts>(*file);
  ASSERT_TRUE(facts) << facts.message();
  EXPECT_EQ(facts->triangles, mesh.size());
  EXPECT_EQ(facts->zero_area, 1u);
  EXPECT_EQ(facts->bounds.lo, mesh_facts(mesh).bounds.lo);
  EXPECT_EQ(facts->bounds.hi, mesh_facts(mesh).bounds.hi);
  EXPECT_FALSE(read<TriangleMesh>(*file));
}

TEST_F(StructureSectionsTest, FactsThatCannotBeAreRefused) {
  const TriangleMesh mesh = grid_mesh(4);
  const MeshFacts good = mesh_facts(mesh);
  const Aabb wide{{0, 0, 0}, {INFINITY, 1, 1}}, unknown{{0, 0, 0}, {NAN, 1, 1}};
  const MeshFacts bad[] = {{1, 0, 0, good.bounds},
                           {good.triangles, good.triangles + 1, 0, good.bounds},
                           {good.triangles, 1, good.triangles, good.bounds},
                           {good.triangles, 0, 0, Aabb{}},
                           {good.triangles, good.triangles, 0, good.bounds},
                           {good.triangles, 0, 0, wide},
                           {good.triangles, 0, 0, unknown}};
  for (const MeshFacts& facts : bad) {
    AccelFileWriter writer;
    writer.add("mesh.triangles", mesh.triangles);
    writer.add_value("mesh.facts", facts);
    ASSERT_TRUE(writer.write(path()));
    EXPECT_FALSE(read<MeshFacts>(*AccelFile::open(path())));
  }
}

// With its optional arrays and without.
TEST_F(StructureSectionsTest, KdTreeComesBack) {
  const TriangleMesh mesh = grid_mesh(20);
  KdTree tree = KdTreeSah::build(mesh, {}).value().structure;
  for (const bool extras : {false, true}) {
    if (extras) add_links(tree), add_ropes(tree);
    ASSERT_TRUE(save_accel(path(), {}, mesh, tree));
    const Result<AccelFile> file = AccelFile::open(path());
    ASSERT_TRUE(file) << file.message();
    const Result<KdTree> back = read<KdTree>(*file);
    ASSERT_TRUE(back) << back.message();
    EXPECT_TRUE(same(back->nodes, tree.nodes));
    EXPECT_TRUE(same(back->leaves.triangles, tree.leaves.triangles));
    EXPECT_TRUE(same(back->leaves.references, tree.leaves.references));
    EXPECT_TRUE(same(back->parents, tree.parents));
    EXPECT_TRUE(same(back->cells, tree.cells));
    EXPECT_TRUE(same(back->ropes, tree.ropes));
    EXPECT_EQ(back->depth, tree.depth);
    EXPECT_EQ(back->leaf_count, tree.leaf_count);
    EXPECT_EQ(back->bounds.lo, tree.bounds.lo);
    EXPECT_EQ(back->size_bytes(), tree.size_bytes());
    EXPECT_EQ(back->has(KdExtras::ropes), extras);
    EXPECT_FALSE(read<Bvh2>(*file));
  }
}

TEST_F(StructureSectionsTest, DamagedKdTreesAreFound) {
  const TriangleMesh mesh = grid_mesh(6);
  KdTree tree = KdTreeSah::build(mesh, {}).value().structure;
  tree.nodes[0] = KdNode::inner(tree.nodes[0].axis(), tree.nodes[0].plane(), 0);
  ASSERT_TRUE(save_accel(path(), {}, mesh, tree));
  const Result<KdTree> back = read<KdTree>(AccelFile::open(path()).value());
  ASSERT_FALSE(back);
  EXPECT_NE(back.message().find("damaged"), std::string::npos) << back.message();
}

TEST_F(StructureSectionsTest, GridComesBack) {
  const TriangleMesh mesh = grid_mesh(20);
  for (const TriangleMesh& scene : {mesh, TriangleMesh{}}) {
    const Grid grid = GridBuilder::build(scene, {}).value().structure;
    ASSERT_TRUE(save_accel(path(), {}, scene, grid));
    const Result<AccelFile> file = AccelFile::open(path());
    ASSERT_TRUE(file) << file.message();
    const Result<Grid> back = read<Grid>(*file);
    ASSERT_TRUE(back) << back.message();
    EXPECT_TRUE(same(back->cells, grid.cells));
    EXPECT_TRUE(same(back->leaves.references, grid.leaves.references));
    EXPECT_TRUE(same(back->leaves.triangles, grid.leaves.triangles));
    EXPECT_EQ(std::memcmp(&back->frame, &grid.frame, sizeof grid.frame), 0);
    EXPECT_FALSE(read<Bvh2>(*file));
  }
}

TEST_F(StructureSectionsTest, GridsAreValidated) {
  const TriangleMesh mesh = grid_mesh(6);
  const auto reads = [&](auto damage) {
    Grid grid = GridBuilder::build(mesh, {}).value().structure;
    damage(grid);
    EXPECT_TRUE(save_accel(path(), {}, mesh, grid));
    const Result<AccelFile> file = AccelFile::open(path());
    return file && read<Grid>(*file).ok();
  };
  EXPECT_TRUE(reads([](Grid&) {}));
  EXPECT_FALSE(reads([](Grid& g) { g.frame.resolution.x += 1; }));
  EXPECT_FALSE(reads([](Grid& g) { g.leaves.references[g.leaves.references.size() - 1] = 0; }));
  EXPECT_FALSE(reads([](Grid& g) { g.cells[0] = static_cast<std::uint32_t>(g.leaves.references.size()); }));
}

TEST_F(StructureSectionsTest, EmptySceneComesBack) {
  const TriangleMesh mesh;
  ASSERT_TRUE(save_accel(path(), {}, mesh, build(mesh)));
  const Result<AccelFile> file = AccelFile::open(path());
  ASSERT_TRUE(file) << file.message();
  const Result<Bvh2> back = read<Bvh2>(*file);
  ASSERT_TRUE(back) << back.message();
  EXPECT_TRUE(back->nodes.empty());
}

// The container's test changes every byte; this one goes through the readers of all sections.
TEST_F(StructureSectionsTest, ChangedBytesAreFound) {
  const TriangleMesh mesh = grid_mesh(3);
  ASSERT_TRUE(save_accel(path(), {}, mesh, build(mesh)));
  const std::string good = contents(path());
  const auto reads = [&](const fs::path& name) {
    const Result<AccelFile> file = AccelFile::open(name);
    return file && read<AccelMetadata>(*file) && read<TriangleMesh>(*file) && read<MeshFacts>(*file) && read<Bvh2>(*file);
  };
  ASSERT_TRUE(reads(path()));
  for (std::size_t i = 0; i < good.size(); i += 5) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 0x10);
    EXPECT_FALSE(reads(file("bad.accel", bad))) << i;
  }
  for (std::size_t size = 0; size < good.size(); size += 17)
    EXPECT_FALSE(reads(file("bad.accel", good.substr(0, size)))) << size;
}

// A file whose checksums are right and whose contents are not: what a broken or hostile writer makes.
TEST_F(StructureSectionsTest, ContentsAreValidated) {
  const TriangleMesh mesh = grid_mesh(6);
  const auto reads = [&](const TriangleMesh& some_mesh, const Bvh2& some_bvh) {
    EXPECT_TRUE(save_accel(path(), {}, some_mesh, some_bvh));
    const Result<AccelFile> file = AccelFile::open(path());
    EXPECT_TRUE(file) << file.message();
    const bool good_mesh = read<TriangleMesh>(*file).ok(), good_bvh = read<Bvh2>(*file).ok();
    return std::pair(good_mesh, good_bvh);
  };
  EXPECT_EQ(reads(mesh, build(mesh)), std::pair(true, true));

  TriangleMesh bad_mesh = grid_mesh(6);
  bad_mesh.triangles[3].v1 = 36;
  EXPECT_FALSE(save_accel(path(), {}, bad_mesh, build(mesh)));
  AccelFileWriter writer;
  writer.add("mesh.vertices", bad_mesh.vertices);
  writer.add("mesh.triangles", bad_mesh.triangles);
  ASSERT_TRUE(writer.write(path()));
  EXPECT_FALSE(read<TriangleMesh>(*AccelFile::open(path())));

  Bvh2 cycle = build(mesh);
  cycle.nodes[cycle.nodes.size() - 1].child[1] = 0;
  EXPECT_EQ(reads(mesh, cycle), std::pair(true, false));

  Bvh2 depth = build(mesh);
  depth.depth += 1;
  EXPECT_EQ(reads(mesh, depth), std::pair(true, false));

  Bvh2 root = build(mesh);
  root.root = 1u << 20;
  EXPECT_EQ(reads(mesh, root), std::pair(true, false));

  // Fewer triangles than the structure names.
  EXPECT_EQ(reads(grid_mesh(5), build(mesh)), std::pair(true, false));
}

}  // namespace
}  // namespace accel
