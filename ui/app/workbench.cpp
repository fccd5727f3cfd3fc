#include "ui/app/workbench.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <thread>
#include <utility>

#include "geometry/base/hash.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/tool/tool_file.h"
#include "preprocess/bake/bake.h"
#include "preprocess/bake/case_recipe.h"
#include "preprocess/close/occlusal_plane.h"
#include "preprocess/demo/demo_anatomy.h"
#include "preprocess/demo/demo_arch.h"
#include "preprocess/unit/unit.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr double kHeadUpTo = 4;          // mm from the tip: what has to be free where a stroke starts
constexpr double kHeadTolerance = 0.05;  // mm

fs::path userDataFolder() {
  if (const char* xdg = std::getenv("XDG_DATA_HOME"); xdg && *xdg == '/') return fs::path(xdg) / "kerf";
  const char* home = std::getenv("HOME");
  return fs::path(home ? home : "/tmp") / ".local/share/kerf";
}

Error readOnly(const fs::path& path) {
  return {.code = Error::Code::kUnsupported,
          .file = path.string(),
          .found = "a run",
          .expected = "a mesh, a recipe or a case to cut",
          .hint = "open the case it was cut from"};
}

// Where a base looks: the axis that the largest flat part of the surface is square to. None: no flat part to speak of.
std::optional<Vec3d> baseNormalOf(const Mesh& solid) {
  constexpr double kFlat = 0.9999, kLeastShare = 0.04;
  std::array<double, 6> area{};
  double all = 0;
  for (const Triangle& t : solid.triangles) {
    const Vec3d& a = solid.vertices[t[0]];
    const Vec3d twice = (solid.vertices[t[1]] - a).cross(solid.vertices[t[2]] - a);
    all += twice.norm();
    for (std::size_t n = 0; n < 6; ++n) {
      const double along = (n < 3 ? -1 : 1) * twice[static_cast<Eigen::Index>(n % 3)];
      if (along > kFlat * twice.norm()) area[n] += along;
    }
  }
  const auto most = static_cast<std::size_t>(std::max_element(area.begin(), area.end()) - area.begin());
  if (!(area[most] > kLeastShare * all)) return {};
  return (most < 3 ? -1.0 : 1.0) * Vec3d::Unit(static_cast<Eigen::Index>(most % 3));
}

// Out of the teeth: away from the base, by the occlusal plane if there is one. Without a base it is not known which way
// is up: the direction in which most cusp tips are found; what is as flat as a base is not teeth.
std::optional<Vec3d> occlusalNormalOf(const Mesh& solid) {
  constexpr double kFlat = 0.05;  // mm
  if (const auto base = baseNormalOf(solid)) {
    const auto found = findOcclusalPlane(solid, -*base);
    return found && found->rms_mm > kFlat && found->normal.dot(-*base) > 0.5 ? found->normal : Vec3d(-*base);
  }
  std::optional<OcclusalPlane> best;
  for (int n = 0; n < 6; ++n) {
    const auto found = findOcclusalPlane(solid, (n < 3 ? 1.0 : -1.0) * Vec3d::Unit(n % 3));
    if (found && found->rms_mm > kFlat && (!best || found->tips > best->tips)) best = *found;
  }
  if (!best) return {};
  return best->normal;
}

// mm^2, in its own unit or the one that is chosen for it.
Expected<double> areaOfScan(const fs::path& path, const std::string& asked_unit) {
  KERF_TRY(file, readMesh(path));
  Box3 box = bounds(file.mesh);
  KERF_TRY(unit, chooseUnit(box, asked_unit, file.declared_unit));
  double area = 0;
  for (const Triangle& t : file.mesh.triangles) {
    const Vec3d& a = file.mesh.vertices[t[0]];
    area += 0.5 * (file.mesh.vertices[t[1]] - a).cross(file.mesh.vertices[t[2]] - a).norm();
  }
  return area * unit.scale_to_mm * unit.scale_to_mm;
}

// What of a tool has to be free before a stroke: vertices near its tip.
Mesh headOf(const Tool& tool) {
  Mesh out;
  for (const Vec3d& v : toolMesh(tool, kHeadTolerance).vertices)
    if (v[2] < kHeadUpTo) out.vertices.push_back(v);
  return out;
}

// Vertices of every triangle, in their order: what a file has to bring back whatever its format.
Expected<void> compareWithFile(const fs::path& file, const Mesh& mesh) {
  KERF_TRY(read, readMesh(file));
  const Mesh& back = read.mesh;
  std::size_t different = back.triangles.size() == mesh.triangles.size() ? 0 : 1;
  for (std::size_t t = 0; different == 0 && t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(k);
      const Vec3d wanted = roundedToFloat(mesh.vertices[mesh.triangles[t][corner]]);
      different += roundedToFloat(back.vertices[back.triangles[t][corner]]) != wanted;
    }
  if (different == 0) return {};
  return fail({.code = Error::Code::kWriteFailed,
               .file = file.string(),
               .found = fmt::format("{} triangles read back, not those that were written", back.triangles.size()),
               .expected = fmt::format("the {} triangles of the mesh, bit for bit", mesh.triangles.size()),
               .hint = "write it again, to another disk"});
}

}  // namespace

double voxelFor(double area_mm2) {
  constexpr double kTriangles = 8e5, kPerVoxel = 3.4;  // triangles a voxel of a scan's area, its base among them
  const double voxel = std::sqrt(kPerVoxel * area_mm2 / kTriangles);
  return std::clamp(std::ceil(100 * voxel) / 100, 0.1, 0.25);
}

const std::vector<std::string>& defaultTools() {
  static const std::vector<std::string> kTools = {
      "round-014", "round-010", "round-018", "us-330",  "856-016",
      "837-012",   "847-016",   "862-012",   "disc-22", "saw-reciprocating-25"};
  return kTools;
}

Workbench::Workbench(WorkbenchOptions options) : options_(std::move(options)) {
  if (options_.data_folder.empty()) options_.data_folder = userDataFolder();
  const auto& wanted = options_.tools.empty() ? defaultTools() : options_.tools;
  for (const std::string& id : wanted) {
    const auto file = findToolFile(id, defaultToolFolders());
    if (!file) {
      complain(file.error());
      continue;
    }
    auto tool = readTool(*file);
    if (!tool) {
      complain(tool.error());
      continue;
    }
    heads_.push_back(headOf(*tool));
    plunges_.push_back(plungeOf(*tool));
    tools_.push_back({*file, std::move(*tool)});
  }
  findLostSessions();
}

Workbench::~Workbench() {
  job_.reset();
  if (run_) (void)run_->finish();
}

// ---- Once a frame

std::vector<MeshChunkPtr> Workbench::update() {
  if (job_ && job_->isOver()) {
    const auto over = std::move(job_);  // what follows may start another one
    const auto done = std::exchange(when_over_, {});
    if (done) done();
  }
  takeNews();
  return std::exchange(fresh_, {});
}

void Workbench::takeNews() {
  if (!run_) return;
  if (run_->thread().update()) {
    report_ = run_->thread().report();
    removed_mm3_ = report_.objects[0].removed_mm3;
  }
  if (run_->thread().updateTimes()) times_ = run_->thread().times();
  const auto chunks = run_->mesher().take();
  surface_.update(chunks);
  fresh_.insert(fresh_.end(), chunks.begin(), chunks.end());

  const RecorderStatus log = run_->recorderStatus();
  if (!log.error || std::exchange(has_told_of_log_, true)) return;
  Error error = *log.error;
  error.hint = "free some space and end the session: what was cut is kept, the log ends here";
  complain(error);
}

// Until what was asked for is done and the mesher knows of it; a second at most.
void Workbench::settle() {
  constexpr std::uint64_t kTicks = 3;  // after a command: what it changed is counted in the next tick
  std::optional<std::uint64_t> done_at;
  for (int n = 0; n < 1000; ++n) {
    takeNews();
    const HapticCounts& c = report_.counts;
    const bool is_done = c.commands_done + c.commands_refused >= sent_ && report_.output.touching == 0;
    if (is_done && !done_at) done_at = report_.tick;
    const bool is_counted = done_at && report_.tick >= *done_at + kTicks;
    if (is_counted && c.edits_waiting == 0 && run_->mesher().editsDone() >= c.edits_pushed) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void Workbench::cancelJob() {
  if (job_) job_->cancel();
}

bool Workbench::isBusy() {
  if (!job_) return false;
  complain({.code = Error::Code::kUnsupported,
            .found = "still at work: " + job_->status().title,
            .hint = "wait for it, or cancel it"});
  return true;
}

// ---- Opening

fs::path Workbench::newSessionFolder(const std::string& name) const {
  const auto now = std::chrono::system_clock::now();
  const auto part = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()) % 1000;
  const std::string base = fmt::format("{}-{:%Y%m%d-%H%M%S}-{:03}", name,
                                       fmt::localtime(std::chrono::system_clock::to_time_t(now)), part.count());
  fs::path out = options_.data_folder / "sessions" / (base + ".run");
  std::error_code ignored;
  for (int n = 2; fs::exists(out, ignored); ++n) out.replace_filename(fmt::format("{}-{}.run", base, n));
  return out;
}

Expected<Workbench::Loaded> Workbench::load(const fs::path& path, const Progress& progress) const {
  Loaded out;
  const Progress second = [&progress](double done, std::string_view step) {
    return kerf::report(progress, 0.7 + 0.3 * done, step);
  };
  const fs::path named = path.has_filename() ? path : path.parent_path();
  out.name = named.stem().string();
  out.source = path;
  if (isRun(path)) return fail(readOnly(path));

  fs::path folder = path;
  if (!isCase(path)) {
    const Progress first = [&progress](double done, std::string_view step) {
      return kerf::report(progress, 0.7 * done, step);
    };
    KERF_TRY(hash, sha256OfFile(path));
    std::error_code failed;
    fs::create_directories(options_.data_folder / "cases", failed);
    BakeOptions bake_options;
    bake_options.unit = options_.unit;
    const bool is_recipe = looksLikeRecipe(path);
    if (options_.voxel_mm > 0) {
      bake_options.voxelize.voxel_mm = options_.voxel_mm;
      bake_options.voxel_is_given = true;
    } else if (!is_recipe) {
      KERF_TRY(area, areaOfScan(path, options_.unit));
      bake_options.voxelize.voxel_mm = voxelFor(area);
    }
    const std::string voxel =
        is_recipe && !bake_options.voxel_is_given ? "" : fmt::format("-{:g}", bake_options.voxelize.voxel_mm);
    const std::string unit = options_.unit.empty() ? "" : "-" + options_.unit;
    const std::string base = fmt::format("{}-{}{}{}", out.name, hash.substr(0, 8), unit, voxel);
    Expected<BakeReport> baked;
    for (int n = 1; n < 100; ++n) {
      folder = options_.data_folder / "cases" / (base + (n > 1 ? fmt::format("-{}", n) : "") + ".case");
      const bool is_there = fs::exists(folder, failed);
      baked = is_recipe ? bakeRecipe(path, folder, bake_options, first) : bake({path}, folder, bake_options, first);
      // A case of another Kerf stays: sessions were cut from it.
      if (baked || !is_there || baked.error().code != Error::Code::kWriteFailed) break;
    }
    if (!baked) return fail(std::move(baked).error());
    for (const std::string& change : baked->manifest.changes) out.notes.push_back(change);
    out.notes.push_back(fmt::format("cut in voxels of {:g} mm", baked->manifest.voxel_mm));
    for (const CaseSource& source : baked->manifest.sources) {
      std::string line = fmt::format("read as {}: {}", source.unit, source.unit_reason);
      if (std::find(out.notes.begin(), out.notes.end(), line) == out.notes.end()) out.notes.push_back(std::move(line));
    }
  }

  LiveRunOptions live;
  live.tools = tools_;
  live.haptic.real_time = options_.real_time;
  live.is_looked_at = true;
  live.haptic.stall_ms = 5000;  // no arm is led: a busy machine need not stop the tool
  KERF_TRY(manifest, readCaseManifest(folder));
  KERF_TRY(solid, readCaseSolid(folder));
  out.occlusal = occlusalNormalOf(solid);
  live.start = {Eigen::Quaterniond::Identity(), manifest.box.center() + Vec3d(0, 0, manifest.box.size()[2])};
  KERF_TRY(run, LiveRun::open(folder, newSessionFolder(out.name), std::move(live), second));
  out.run = std::move(run);
  return out;
}

std::span<const char* const> Workbench::demoNames() {
  static constexpr const char* kNames[] = {"molar", "mandible", "arch"};
  return kNames;
}

Expected<fs::path> Workbench::makeDemo(const std::string& name, const Progress& progress) const {
  const fs::path folder = options_.data_folder / "demo" / name;
  const std::string manifest = name + (name == "arch" ? ".ply" : ".toml");
  std::error_code ignored;
  if (fs::exists(folder / manifest, ignored)) return folder / manifest;

  fs::create_directories(folder.parent_path(), ignored);
  if (name == "arch") {
    KERF_TRY(scan, demoArch({}, progress));
    DemoAnatomy anatomy{name, "Demo lower arch", 0, {}, {}, {}};
    anatomy.files.push_back({manifest, std::move(scan.mesh)});
    KERF_CHECK(writeDemoAnatomy(anatomy, folder, true));
    return folder / manifest;
  }
  KERF_TRY(anatomy, name == "molar" ? demoMolarAnatomy(1, progress) : demoMandible(1, progress));
  KERF_CHECK(writeDemoAnatomy(anatomy, folder, true));
  return folder / manifest;
}

void Workbench::open(const fs::path& path) {
  openBy("opening " + path.filename().string(),
         [this, path](const Progress& progress) { return load(path, progress); });
}

void Workbench::openDemo(const std::string& name) {
  openBy("opening the demo " + name, [this, name](const Progress& progress) -> Expected<Loaded> {
    const Progress first = [&progress](double done, std::string_view step) {
      return kerf::report(progress, 0.3 * done, step);
    };
    const Progress second = [&progress](double done, std::string_view step) {
      return kerf::report(progress, 0.3 + 0.7 * done, step);
    };
    KERF_TRY(path, makeDemo(name, first));
    return load(path, second);
  });
}

void Workbench::openBy(const std::string& title, Load load) {
  if (isBusy()) return;
  auto job = std::make_unique<Job<Loaded>>(title, std::move(load));
  job_writes_ = false;
  when_over_ = [this, job = job.get()] {
    auto loaded = job->take();
    if (!loaded) return complain(loaded.error());
    const auto next = std::make_shared<Loaded>(std::move(*loaded));
    if (!run_) return show(*next);

    // What was open is written only now that there is something in its place.
    close();
    const auto closing = std::exchange(when_over_, {});
    when_over_ = [this, closing, next] {
      closing();
      show(*next);
    };
  };
  job_ = std::move(job);
}

void Workbench::show(Loaded& loaded) {
  const auto object = loaded.run->sharedObject();
  auto hand = std::make_unique<MouseHand>(std::shared_ptr<const BrickField>(object, &object->phi0()),
                                          loaded.run->thread().session().state().body.pose,
                                          loaded.run->model().settings.coupling.stiffness);
  const auto started = loaded.run->start(*hand);
  if (!started) {
    (void)loaded.run->finish();
    return complain(started.error());
  }
  hand_ = std::move(hand);
  run_ = std::move(loaded.run);
  name_ = loaded.name;
  source_ = loaded.source;
  sent_ = 0;
  report_ = {};
  has_told_of_log_ = false;
  fresh_.clear();
  occlusal_ = loaded.occlusal;
  session_ = run_->folder();
  surface_.clear();
  tool_ = 0;
  aim_ = {};
  stroke_.reset();
  removed_mm3_ = 0;
  ++generation_;
  for (std::string& note : loaded.notes) say(std::move(note));
}

void Workbench::close() {
  if (isBusy() || !run_) return;
  release();
  std::shared_ptr<LiveRun> ending = std::move(run_);
  std::shared_ptr<MouseHand> hand = std::move(hand_);
  const std::string name = name_;
  surface_.clear();
  ++generation_;
  auto job = std::make_unique<Job<RunManifest>>(
      "writing the session of " + name, [ending, hand](const Progress&) { return ending->finish(); }, false);
  job_writes_ = true;
  when_over_ = [this, job = job.get(), folder = session_] {
    auto written = job->take();
    if (written)
      say(fmt::format("session written: {}\nas a mesh again: kerf export {} -o OUT.stl", folder.string(),
                      folder.string()));
    else if (written.error().code != Error::Code::kEmpty)
      complain(written.error());
  };
  job_ = std::move(job);
}

// ---- Tools

void Workbench::selectTool(std::size_t n) {
  if (!run_ || n >= toolCount() || n == tool_) return;
  release();
  if (send(SelectTool{n})) tool_ = n;
}

bool Workbench::selectTool(const std::string& id) {
  for (std::size_t n = 0; n < toolCount(); ++n)
    if (tool(n).id == id) {
      selectTool(n);
      return true;
    }
  return false;
}

// ---- By mouse

std::optional<ToolOverSurface> Workbench::over(const Ray& ray) const {
  if (!run_) return {};
  return toolOver(surface_, run_->object().phi0(), ray, plunges_[tool_]);
}

bool Workbench::press(const Ray& ray) {
  const auto at = over(ray);
  if (!at) return false;
  // A mouse is no arm that could be struck: after a late clock it goes on at once.
  if (report_.is_latched) send(ClearLatch{});
  stroke_.emplace(run_->object().phi0(), *at, plunges_[tool_], heads_[tool_]);
  ++aim_.stroke;
  aim_.is_pressed = true;
  aim_.anchor = aim_.pointer = stroke_->anchor();
  aim_.into = -stroke_->axis();
  aim_.reach = plunges_[tool_].reach;
  sendAim();

  const Rigid3& start = stroke_->start();
  const Eigen::Quaterniond& q = start.rotation;
  send(PlaceTool{{start.translation[0], start.translation[1], start.translation[2]}, {q.w(), q.x(), q.y(), q.z()}});
  return true;
}

bool Workbench::send(const Command& command) {
  if (!run_->send(command)) return false;
  ++sent_;
  return true;
}

void Workbench::drag(const Ray& ray) {
  if (!stroke_) return;
  aim_.pointer = stroke_->pointerOf(ray);
  sendAim();
}

void Workbench::deepen(double mm) {
  depth_mm = std::clamp(depth_mm + mm, 0.0, kMostDepth);
  if (stroke_) sendAim();
}

void Workbench::setForce(double newtons) {
  force = std::clamp(newtons, kLeastForce, kMostForce);
  if (stroke_) sendAim();
}

void Workbench::pushHarder(double factor) {
  push_factor_ = factor;
  if (stroke_) sendAim();
}

void Workbench::release() {
  if (!stroke_) return;
  stroke_.reset();
  aim_.is_pressed = false;
  sendAim();
}

void Workbench::sendAim() {
  aim_.force = std::min(force * push_factor_, kMostForce);
  aim_.depth = depth_mm;
  aim_.irrigation = irrigation;
  hand_->aim(aim_);
}

std::optional<double> Workbench::depthNow() const {
  if (!stroke_) return {};
  return stroke_->depthOf(report_.output.T_world_tool.translation);
}

void Workbench::undo() {
  if (!run_) return;
  release();
  send(Undo{});
}

void Workbench::redo() {
  if (!run_) return;
  release();
  send(Redo{});
}

// ---- Results

void Workbench::exportTo(const fs::path& file) {
  if (isBusy()) return;
  if (!run_) return complain({.code = Error::Code::kEmpty, .found = "nothing is open", .hint = "open a scan first"});
  if (const auto possible = canWriteMesh(file); !possible) return complain(possible.error());

  std::error_code ignored;
  if (fs::equivalent(file, source_, ignored))
    return complain({.code = Error::Code::kBadValue,
                     .file = file.string(),
                     .found = "the file that was opened",
                     .expected = "another one: a scan is never written over",
                     .hint = "another name"});
  release();
  settle();

  // The job works on a copy: the cut may go on.
  job_writes_ = true;
  auto changed = std::make_shared<BrickField>(run_->changedField());
  const LiveRun* const run = run_.get();
  auto job = std::make_unique<Job<std::string>>(
      "exporting " + file.filename().string(), [run, changed, file](const Progress& progress) -> Expected<std::string> {
        KERF_TRY(result, run->postOperative(*changed, {}, progress));
        KERF_CHECK(writeMesh(file, result.mesh));
        KERF_CHECK(compareWithFile(file, result.mesh));
        const MeshReport verdict = checkMesh(result.mesh);
        const PostOpReport& r = result.report;
        return fmt::format("{}: {} triangles, removed {:.3f} mm3, {} vertices of the scan kept bit for bit; {}",
                           file.string(), result.mesh.triangles.size(), r.removed_volume_mm3, r.source_vertices_kept,
                           verdict.print_ready ? "ready to print" : "NOT ready to print, see kerf check");
      });
  when_over_ = [this, job = job.get()] {
    auto written = job->take();
    written ? say(std::move(*written)) : complain(written.error());
  };
  job_ = std::move(job);
}

// ---- After a crash

void Workbench::findLostSessions() {
  lost_.clear();
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(options_.data_folder / "sessions", failed)) {
    const auto manifest = readRunManifest(entry.path());
    if (!manifest || !manifest->is_open || !RunLock::take(entry.path())) continue;
    lost_.push_back({entry.path(), fs::path(manifest->case_path).stem().string()});
  }
  const auto timeOf = [](const LostSession& lost) {
    std::error_code none;
    return fs::last_write_time(lost.folder / "session.kerflog", none);
  };
  std::sort(lost_.begin(), lost_.end(),
            [&](const LostSession& a, const LostSession& b) { return timeOf(a) > timeOf(b); });
}

void Workbench::recover(std::size_t n) {
  if (isBusy() || n >= lost_.size()) return;
  job_writes_ = true;
  const fs::path folder = lost_[n].folder;
  auto job =
      std::make_unique<Job<Recovery>>("recovering " + folder.filename().string(),
                                      [folder](const Progress& progress) { return recoverRun(folder, progress); });
  when_over_ = [this, job = job.get(), folder] {
    auto recovered = job->take();
    if (recovered) {
      const Replay& replay = recovered->replay;
      const bool differs = !replay.is_same && replay.checks > 0;
      notices_.push_back({differs, fmt::format("recovered {:.1f} s, {:.3f} mm3 removed: {}\n{}{}",
                                               recovered->manifest.duration_s, replay.removed_mm3, folder.string(),
                                               replay.note, differs ? "; it DIFFERS from what was recorded" : "")});
    } else if (recovered.error().code == Error::Code::kEmpty) {
      // A session without a cut is none: its folder holds nothing that anybody made.
      std::error_code ignored;
      fs::remove_all(folder, ignored);
      say("nothing had been cut in that session");
    } else {
      complain(recovered.error());
    }
    findLostSessions();
  };
  job_ = std::move(job);
}

}  // namespace kerf
