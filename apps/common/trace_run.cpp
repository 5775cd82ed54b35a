#include "apps/common/trace_run.h"

#include <tbb/info.h>
#include <unistd.h>

#include <algorithm>

#include "apps/common/ambient.h"
#include "apps/common/checker.h"
#include "apps/common/device_engine.h"
#include "apps/common/embree_rivals.h"
#include "apps/common/image.h"
#include "apps/common/method_set.h"
#include "apps/common/output.h"
#include "apps/common/ray_batch.h"
#include "apps/common/scaling.h"
#include "apps/common/sweep.h"
#include "apps/common/text.h"
#include "apps/common/trace_pictures.h"
#include "libaccel/io/npy.h"
#include "libaccel/rays/ray_kind.h"

namespace accel::apps {

namespace {

// The first kind of rays that belong to pixels; empty without one.
std::string first_image_kind(const std::vector<std::string>& kinds) {
  for (const std::string& kind : kinds)
    if (const auto parsed = parse_ray_kind(kind); parsed && info(*parsed).is_image) return kind;
  return {};
}

class TraceRun {
 public:
  // Files are added to `outputs`, for the caller to publish.
  TraceRun(const TraceSettings& settings, const Terminal& terminal, ProgressBar& bar, Scene scene, std::string device,
           PendingOutputs& outputs)
      : settings_(settings),
        terminal_(terminal),
        bar_(bar),
        scene_(std::move(scene)),
        outputs_(outputs),
        embree_(scene_, settings.common, bar) {
    report_.device = std::move(device);
    if (!settings.report.empty()) pictured_kind_ = first_image_kind(settings.ray_kinds);
  }

  Outcome<TraceReport> run() {
    describe_scene();
    describe_skipped_triangles();
    terminal_.detail("loaded " + scene_.name + ": " + counted(scene_.facts.triangles, "triangle") + " in " +
                     seconds_text(scene_.load_seconds));
    auto set = prepare_methods(scene_, settings_, bar_, report_.skipped);
    if (!set) return set.failure();
    if (set->members.empty()) return Failure(ExitStatus::error, "no method fits '" + scene_.name + "'; --list shows all");
    auto maker = RayMaker::create(scene_, settings_, set->members.front().accel);
    if (!maker) return maker.failure();
    report_.camera = maker->camera();
    for (const StructureRow& row : set->structures)
      terminal_.detail((scene_.stored ? "read " : "built ") + row.name + ": " + bytes_text(row.bytes) +
                       (row.build_seconds > 0 ? ", " + seconds_text(row.build_seconds) : ""));
    auto checker = Checker::create(scene_, settings_, embree_, bar_, report_.skipped);
    if (!checker) return checker.failure();
    rival_truth_ = truth_of_rivals(*set, *checker);
    auto rivals = make_rivals(embree_, settings_, rival_truth_, report_.skipped);
    if (!rivals) return rivals.failure();
    rivals_ = *std::move(rivals);
    describe_structures(*set, *checker);
    configurations_ = configurations(*set, settings_, report_.skipped);
    if (settings_.sweep && !counter_.reason().empty()) report_.skipped.push_back({"instructions a ray", counter_.reason()});
    if (auto done = make_engines(); !done) return done.failure();
    for (const std::string& kind : settings_.ray_kinds)
      if (auto done = trace_kind(kind, *maker, *checker); !done) return done.failure();
    if (settings_.sweep) place_on_plane(report_, settings_);
    if (auto done = write_view(set->members.front().accel, *maker); !done) return done.failure();
    return std::move(report_);
  }

 private:
  void describe_scene() {
    report_.scene = scene_.name;
    report_.triangles = scene_.facts.triangles;
    report_.facts = scene_.facts;
    report_.load_seconds = scene_.load_seconds;
    report_.threads = settings_.common.threads > 0 ? settings_.common.threads : tbb::info::default_concurrency();
  }

  // Faces and triangles that loaders and builders drop: never silently.
  void describe_skipped_triangles() {
    const MeshFacts& facts = scene_.facts;
    if (scene_.skipped_faces > 0)
      report_.skipped.push_back(
          {counted(scene_.skipped_faces, "face"), it_has(scene_.skipped_faces) + " fewer than three corners"});
    if (facts.zero_area > 0)
      report_.skipped.push_back({counted(facts.zero_area, "triangle"), it_has(facts.zero_area) + " no area"});
    if (facts.out_of_range > 0)
      report_.skipped.push_back({counted(facts.out_of_range, "triangle"),
                                 it_has(facts.out_of_range) + " a coordinate that is not finite or too large"});
  }

  // Methods that share a structure share most of its notes.
  void take_notes(const std::vector<BuildNote>& notes) {
    for (const BuildNote& note : notes) {
      const auto is_same = [&](const BuildNote& other) { return other.what == note.what && other.why == note.why; };
      if (std::none_of(report_.notes.begin(), report_.notes.end(), is_same)) report_.notes.push_back(note);
    }
  }

  void describe_structures(const MethodSet& set, const Checker& checker) {
    report_.structures = set.structures;
    for (const MethodSet::Member& member : set.members) take_notes(member.accel.report().notes);
    report_.checked_by = checker.description();
    report_.witness = checker.has_witness() ? embree_.name() : "";
    for (const EmbreeRival& rival : rivals_) rival_structures_.push_back(structure_row(*rival.scene));
  }

  // Embree has instances where one of the methods has, and else one mesh, as all of them.
  static Truth truth_of_rivals(const MethodSet& set, const Checker& checker) {
    const auto has_instances = [&](const MethodSet::Member& member) {
      return checker.truth_of(member.accel.method()) == Truth::as_it_is;
    };
    return std::any_of(set.members.begin(), set.members.end(), has_instances) ? Truth::as_it_is : Truth::one_mesh;
  }

  // The row of an Embree scene, which modes may share.
  std::size_t structure_row(const validation::EmbreeWitness& scene) {
    const std::string name = structure_name(scene);
    std::size_t row = 0;
    while (row < report_.structures.size() && report_.structures[row].name != name) ++row;
    if (row == report_.structures.size())
      report_.structures.push_back({name, scene.build_seconds(), scene.size_bytes(), {}, {}});
    return row;
  }

  Finished make_engines() {
    for (const Configuration& configuration : configurations_) {
      const AnyAccel& accel = configuration.member->accel;
      if (const Status accepted = accel.accepts(configuration.test); !accepted) return accepted.error();
      if (settings_.device == "cpu") {
        engines_.push_back(engine_of(accel, trace_options(configuration.test)));
        continue;
      }
      auto engine = device_engine_of(accel, configuration.test);
      if (!engine) return engine.failure();
      engines_.push_back(*std::move(engine));
    }
    return Done{};
  }

  // Refuses batches that cannot fit into this machine, before the machine does so by killing the program.
  Finished check_memory(const std::string& kind) const {
    if (kind.ends_with(".npy")) return Done{};  // its rays are in memory already, when their number is known
    const std::uint64_t rays = most_rays(settings_, kind);
    const std::uint64_t orders = settings_.sort ? 2 : 1;
    const std::uint64_t nearest = settings_.hits > 0 && kind == settings_.ray_kinds.front() ? settings_.hits : 0;
    const std::uint64_t bytes = rays * ((sizeof(Ray) + sizeof(std::uint32_t)) * orders +
                                        sizeof(Hit) * (orders * engines_.size() + rivals_.size() + 1 + nearest));
    const auto memory = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    if (bytes <= memory) return Done{};
    return Failure(ExitStatus::error, counted(rays, "ray") + " of kind " + kind + " need " + bytes_text(bytes) +
                                          ", and this machine has " + bytes_text(memory) +
                                          "; make --width, --height, --spp or --count smaller" +
                                          (nearest > 0 ? ", or --hits" : ""));
  }

  // Everything about one kind of rays: time all methods and the witness in turns, count, check.
  Finished trace_kind(const std::string& kind, RayMaker& maker, Checker& checker) {
    if (auto fits = check_memory(kind); !fits) return fits;
    bar_.begin("tracing " + kind);
    auto batch = maker.make(kind);
    if (!batch) return batch.failure();
    std::vector<Engine> engines = engines_;
    std::optional<SortedRays> sorted;
    if (settings_.sort) {
      bar_.begin("sorting " + kind);
      auto made = sorted_rays(batch->rays(), scene_.facts.bounds,
                              {*settings_.sort, settings_.packets.cell_fraction, settings_.common.threads}, settings_.repeat);
      if (!made) return made.error();
      sorted = *std::move(made);
      for (Engine engine : engines_) {
        engine.name += ", sorted", engine.own_rays = sorted->rays.span();
        engines.push_back(std::move(engine));
      }
      bar_.begin("tracing " + kind);
    }
    const std::size_t first_rival = engines.size();
    const Buffer<Ray> tiles = add_rivals(*batch, engines);
    terminal_.detail("tracing " + counted(batch->size(), "ray") + " of kind " + batch->name);
    auto measured = measure(engines, batch->rays(), batch->query, settings_.repeat, bar_, &counter_);
    if (!measured) return measured.failure();

    std::optional<Answers> testimonies[2];  // by truth
    const auto testimony_for = [&](Truth truth) -> Outcome<const Answers*> {
      std::optional<Answers>& testimony = testimonies[static_cast<int>(truth)];
      if (!testimony) {
        auto answers = checker.testify(*batch, truth);
        if (!answers) return answers.failure();
        testimony = *std::move(answers);
      }
      return &*testimony;
    };
    for (std::size_t m = 0; m < configurations_.size(); ++m) {
      const bool is_first = m == 0 && kind == settings_.ray_kinds.front();
      const bool is_pictured = kind == pictured_kind_ && configurations_[m].promised;
      const Truth truth = checker.truth_of(configurations_[m].member->accel.method());
      const auto testimony = testimony_for(truth);
      if (!testimony) return testimony.failure();
      const Traced traced{configurations_[m], engines[m], *batch, (*measured)[m], truth, **testimony, is_first, is_pictured};
      if (auto done = examine(traced, maker, checker); !done) return done;
      if (sorted) compare_orders(traced, (*measured)[engines_.size() + m], *sorted);
    }
    // A sweep has Embree on its plane, too.
    const auto testimony = settings_.sweep ? testimony_for(rival_truth_) : Outcome<const Answers*>(nullptr);
    if (!testimony) return testimony.failure();
    for (std::size_t r = 0; r < rivals_.size(); ++r)
      if (auto done = add_rival_row(r, *batch, (*measured)[first_rival + r], *testimony, checker); !done) return done;
    return Done{};
  }

  // Returns the rays of those that take tiles.
  Buffer<Ray> add_rivals(const RayBatch& batch, std::vector<Engine>& engines) const {
    const auto is_tiled = [](const EmbreeRival& rival) { return takes_tiles(*rival.timed); };
    Buffer<Ray> tiles;
    if (std::any_of(rivals_.begin(), rivals_.end(), is_tiled)) tiles = by_tiles(batch.set, settings_.width);
    for (const EmbreeRival& rival : rivals_) {
      engines.push_back(rival.engine);
      if (is_tiled(rival)) engines.back().own_rays = tiles.span();
    }
    return tiles;
  }

  // A method's answers to a batch, and what they are compared with.
  struct Traced {
    const Configuration& configuration;
    const Engine& engine;
    const RayBatch& batch;
    const Measurement& measured;
    Truth truth;
    const Answers& testimony;
    bool is_first;     // the method and kind that files are about
    bool is_pictured;  // in the report

    const AnyAccel& accel() const { return configuration.member->accel; }
  };

  Finished examine(const Traced& traced, RayMaker& maker, Checker& checker) {
    const std::string& method = traced.accel().method().name;
    TraceRow row = row_of(method, traced.batch, traced.measured, traced.configuration.member->structure);
    row.test = traced.configuration.test, row.promised = traced.configuration.promised;
    const bool in_file = traced.is_first && !settings_.heatmap.empty();
    std::vector<std::uint32_t> steps(in_file || traced.is_pictured ? traced.batch.size() : 0);
    // A sweep's tests share the steps of their method.
    if (!settings_.sweep || row.promised)
      if (auto done = count(traced, steps, row); !done) return done;
    if (auto done = profile(traced, row); !done) return done;
    if (checker.checks()) {
      bar_.begin("checking " + method + ", " + traced.batch.name);
      auto checked = checker.check(traced.batch, traced.truth, traced.measured.answers, traced.testimony,
                                   traced.is_pictured || (traced.is_first && !settings_.diff.empty()));
      if (!checked) return checked.failure();
      row.check = *std::move(checked);
      if (row.promised && row.check->failures() > 0) write_bundle(traced, checker, row);
    }
    if (traced.is_pictured) keep_pictures(traced, row, steps, maker.picture_size());
    if (traced.is_first)
      if (auto done = write_files(traced, row, steps, maker, checker); !done) return done;
    report_.rows.push_back(std::move(row));
    return Done{};
  }

  void keep_pictures(const Traced& traced, const TraceRow& row, std::span<const std::uint32_t> steps, PictureSize size) {
    const RaySet& set = traced.batch.set;
    MethodPictures pictures{row.method,
                            row.rays_kind,
                            shrunk(heat_picture(steps, settings_.heatmap_of, set, size, row.method), kMostReportPixels),
                            {}};
    if (row.check) pictures.verdicts = shrunk(verdicts_picture(*row.check, set, size), kMostReportPixels);
    report_.pictures.push_back(std::move(pictures));
  }

  // Sorting must change no answer, and may change the speed.
  void compare_orders(const Traced& traced, const Measurement& in_order, const SortedRays& sorted) {
    SortRow row{traced.accel().method().name, traced.batch.name, traced.batch.size(), sorted.order.chunks, sorted.cost};
    row.as_they_came = traced.measured.speed, row.sorted = in_order.speed;
    const Answers answers = unsorted(in_order.answers, sorted.order, settings_.common.threads, row.cost);
    row.query = traced.batch.query;
    row.different = differences(traced.measured.answers, answers);
    report_.sorts.push_back(std::move(row));
  }

  Finished count(const Traced& traced, std::span<std::uint32_t> steps, TraceRow& row) {
    bar_.begin("counting steps of " + traced.engine.name);
    Counters total;
    const std::span<const Ray> rays = traced.batch.rays();
    for (std::size_t begin = 0; begin < rays.size(); begin += traced.engine.rays_per_call) {
      if (!bar_.update(traced.batch.name, static_cast<double>(begin) / static_cast<double>(rays.size())))
        return Error{std::string(kInterrupted)};
      const std::size_t size = std::min(traced.engine.rays_per_call, rays.size() - begin);
      const auto part = steps.empty() ? steps : steps.subspan(begin, size);
      const auto counted_part = traced.accel().count(rays.subspan(begin, size), traced.batch.query, part,
                                                     trace_options(traced.configuration.test), settings_.heatmap_of);
      if (!counted_part) return counted_part.error();
      total += *counted_part;
    }
    row.counters = total;
    return Done{};
  }

  Finished profile(const Traced& traced, TraceRow& row) {
    const AnyAccel& accel = traced.accel();
    const TraceOptions options = trace_options(traced.configuration.test);
    if (settings_.profile_simt) {
      bar_.begin("simulating warps of " + traced.engine.name);
      const SimtOptions simt{settings_.schedule};
      const auto simulate = [&](std::span<const Ray> rays) {
        return accel.profile_simt(rays, traced.batch.query, {}, simt, options);
      };
      if (auto done = add_parts(traced.batch, std::size_t{32} * simt.rays_per_warp, simulate, row.simt.emplace()); !done)
        return done;
    }
    if (!settings_.profile_multipass) return Done{};
    bar_.begin("running passes of " + traced.engine.name);
    const auto run_passes = [&](std::span<const Ray> rays) {
      return accel.trace_multipass(rays, traced.batch.query, {}, settings_.multipass, options);
    };
    return add_parts(traced.batch, settings_.multipass.batch_size, run_passes, row.multipass.emplace());
  }

  // The profile of a batch as the sum of those of its parts, between which interruptions are obeyed. A part is a whole number
  // of the units that a model works off one after the other, so that the sum is what one call would give.
  template <class Profile, class Run>
  Finished add_parts(const RayBatch& batch, std::size_t part, const Run& run, Profile& sum) {
    const std::span<const Ray> rays = batch.rays();
    for (std::size_t begin = 0; begin < rays.size(); begin += part) {
      const std::size_t size = std::min(part, rays.size() - begin);
      const auto profile = run(rays.subspan(begin, size));
      if (!profile) return profile.error();
      sum += *profile;
      if (!bar_.update(batch.name, static_cast<double>(begin + size) / static_cast<double>(rays.size())))
        return Error{std::string(kInterrupted)};
    }
    return Done{};
  }

  static TraceRow row_of(const std::string& name, const RayBatch& batch, const Measurement& measured, std::size_t structure) {
    TraceRow row{name, batch.name, batch.size(), measured.speed, measured.passes, structure};
    row.query = batch.query;
    if (const auto instructions = measured.instructions(); instructions && batch.size() > 0)
      row.instructions = *instructions / static_cast<double>(batch.size());
    return row;
  }

  // The testimony is that of sweeps; it does not fit modes that traced the rays in another order.
  Finished add_rival_row(std::size_t rival, const RayBatch& batch, const Measurement& measured, const Answers* testimony,
                         Checker& checker) {
    const EmbreeRival& of = rivals_[rival];
    TraceRow row = row_of(of.engine.name, batch, measured, rival_structures_[rival]);
    row.embree = of.timed, row.promised = false;
    if (testimony != nullptr && !takes_tiles(*of.timed)) {
      auto checked = checker.check(batch, rival_truth_, measured.answers, *testimony, false);
      if (!checked) return checked.failure();
      row.check = *std::move(checked);
    }
    report_.rows.push_back(std::move(row));
    return Done{};
  }

  Finished write_files(const Traced& traced, const TraceRow& row, std::span<const std::uint32_t> steps, RayMaker& maker,
                       Checker& checker) {
    const std::string subject = row.method + ", " + row.rays_kind + ", " + scene_.title;
    const auto rays = [&](const std::string& path) { return as_finished(write_rays_npy(path, traced.batch.rays())); };
    const auto hits = [&](const std::string& path) {
      return settings_.hits > 0 ? write_nearest(traced, path) : as_finished(write_hits(traced, path));
    };
    const auto heatmap = [&](const std::string& path) {
      const HeatPicture picture = heat_picture(steps, settings_.heatmap_of, traced.batch.set, maker.picture_size(), subject);
      return write_heat(path, picture, counter_name(settings_.heatmap_of));
    };
    const auto diff = [&](const std::string& path) {
      const Difference difference{traced.batch, traced.measured.answers, traced.testimony, *row.check,
                                  checker.judge(traced.truth)};
      const DifferencePictures pictures = difference_pictures(difference, maker.picture_size(), subject);
      return write_classes(path, pictures.distance, pictures.verdicts, "t_difference_ulp");
    };
    if (auto done = outputs_.add(settings_.rays_out, rays); !done) return done;
    if (auto done = outputs_.add(settings_.hits_out, hits); !done) return done;
    if (auto done = outputs_.add(settings_.heatmap, heatmap); !done) return done;
    return outputs_.add(settings_.diff, diff);
  }

  static Finished as_finished(const Status& status) { return status ? Finished(Done{}) : Finished(status.error()); }

  // The nearest hits of each ray, traced for this file alone.
  Finished write_nearest(const Traced& traced, const std::string& path) {
    const std::span<const Ray> rays = traced.batch.rays();
    const std::size_t k = settings_.hits;
    if (rays.size() > kMaxRays / k)
      return Error{"--hits: " + std::to_string(k) + " hits of each of " + with_commas(rays.size()) + " rays are more than " +
                   with_commas(kMaxRays)};
    bar_.begin("finding the nearest hits by " + traced.engine.name);
    std::vector<Hit> hits(rays.size() * k);
    std::vector<std::uint32_t> counts(rays.size());
    for (std::size_t begin = 0; begin < rays.size(); begin += traced.engine.rays_per_call) {
      if (!bar_.update(traced.batch.name, static_cast<double>(begin) / static_cast<double>(rays.size())))
        return Error{std::string(kInterrupted)};
      const std::size_t size = std::min(traced.engine.rays_per_call, rays.size() - begin);
      const Status found =
          traced.accel().k_nearest(rays.subspan(begin, size), k, std::span(hits).subspan(begin * k, size * k),
                                   std::span(counts).subspan(begin, size), trace_options(traced.configuration.test));
      if (!found) return found.error();
    }
    return as_finished(write_hits_npy(path, hits, k));
  }

  // Any-hit answers have no t and no primitive: they are written as prim_id 0 for occluded.
  static Status write_hits(const Traced& traced, const std::string& path) {
    const Answers& answers = traced.measured.answers;
    if (traced.batch.query == Query::closest) return write_hits_npy(path, answers.hits.span());
    std::vector<Hit> hits(answers.occluded.size());
    for (std::size_t i = 0; i < hits.size(); ++i)
      if (answers.occluded[i] != 0) hits[i] = Hit{0, 0, 0, 0};
    return write_hits_npy(path, hits);
  }

  // The view with soft shadows in its corners: more directions where there are fewer rays to average.
  Finished write_view(const AnyAccel& accel, RayMaker& maker) {
    if (settings_.image.empty()) return Done{};
    bar_.begin("shading " + settings_.image);
    auto view = maker.view();
    if (!view) return view.failure();
    constexpr std::uint32_t kDirectionsPerPixel = 32;
    const int directions = static_cast<int>(std::max(kDirectionsPerPixel / settings_.spp, 1u));
    const PrimaryHits from{scene_.triangles(), view->rays, view->hits};
    const float reach = default_ao_distance(scene_.facts.bounds);
    const auto open = openness(accel, from, reach, directions, settings_.common.seed, settings_.common.threads, bar_);
    if (!open) return open.failure();
    const ShadedPicture picture = shade(scene_.triangles(), view->rays, view->hits, maker.picture_size(), *open);
    return outputs_.add(settings_.image, [&](const std::string& path) { return write_shaded(path, picture); });
  }

  // Files that show what went wrong. Failing to write them must not hide it.
  void write_bundle(const Traced& traced, Checker& checker, TraceRow& row) {
    std::string stem = settings_.repro + "-" + row.method + "-" + row.rays_kind;
    std::replace(stem.begin() + static_cast<std::ptrdiff_t>(settings_.repro.size()), stem.end(), '/', '-');
    std::vector<std::string> options = settings_.hit_options;
    if (makes_packets(row.method))
      options.insert(options.end(), settings_.packet_options.begin(), settings_.packet_options.end());
    if (!row.test.empty()) options.insert(options.end(), {"--test", row.test});
    const auto written =
        checker.write_bundle(stem, traced.batch, traced.truth, traced.measured.answers, traced.testimony, *row.check,
                             {settings_.common.command_line, scene_.name, row.method, traced.batch.query, std::move(options)});
    if (written)
      row.repro = *written;
    else
      terminal_.warning("no repro bundle: " + written.failure().message);
  }

  TraceOptions trace_options(const std::string& test) const { return {settings_.common.threads, test, settings_.packets}; }

  const TraceSettings& settings_;
  const Terminal& terminal_;
  ProgressBar& bar_;
  Scene scene_;
  PendingOutputs& outputs_;
  TraceReport report_;
  InstructionCounter counter_;
  std::vector<Configuration> configurations_;
  std::vector<Engine> engines_;  // one for each configuration
  EmbreeScenes embree_;
  std::vector<EmbreeRival> rivals_;
  Truth rival_truth_ = Truth::as_it_is;
  std::vector<std::size_t> rival_structures_;  // their rows among the structures
  std::string pictured_kind_;                  // the kind of rays of the report's pictures; empty: there are none
};

// A structure file need not give its triangles for rays that come from elsewhere and hits that nobody checks.
MeshUse mesh_use(const TraceSettings& settings) {
  const bool reads = settings.check != Check::none || !settings.embree.empty() || !settings.image.empty() ||
                     std::any_of(settings.ray_kinds.begin(), settings.ray_kinds.end(), rays_need_mesh);
  return reads ? MeshUse::reads : MeshUse::none;
}

}  // namespace

Outcome<TraceReport> run_trace(const TraceSettings& settings, const Terminal& terminal, ProgressBar& bar) {
  std::string device = "cpu";
  if (settings.device == "cuda") {
    auto found = find_device();
    if (!found) return found.failure();
    device = *found;
  }
  bar.begin("loading " + settings.scene);
  auto scene = open_scene(settings.scene, settings.common.seed, bar.callback(), mesh_use(settings));
  if (!scene) return scene.failure();
  PendingOutputs outputs;
  auto report = TraceRun(settings, terminal, bar, *std::move(scene), device, outputs).run();
  if (!report) return report;
  for (const std::string& size : settings.scaling) {
    const auto run = run_trace(settings_for_size(settings, size), terminal, bar);
    if (!run) return run.failure();
    add_points(*run, report->scaling);
    for (const Skip& skip : run->skipped) {
      const auto is_same = [&](const Skip& other) { return other.what == skip.what && other.why == skip.why; };
      if (std::none_of(report->skipped.begin(), report->skipped.end(), is_same))
        report->skipped.push_back({skip.what + " in " + run->scene, skip.why});
    }
  }
  if (auto done = outputs.publish(); !done) return done.failure();
  return report;
}

}  // namespace accel::apps
