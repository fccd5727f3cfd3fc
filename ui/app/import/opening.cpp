#include "ui/app/import/opening.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <utility>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "preprocess/bake/bake.h"
#include "preprocess/bake/case_recipe.h"
#include "preprocess/demo/demo_anatomy.h"
#include "preprocess/demo/demo_arch.h"
#include "preprocess/unit/unit.h"
#include "preprocess/volume/label_volume.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/session/session_run.h"
#include "ui/app/base/language.h"
#include "ui/app/import/label_plan.h"
#include "ui/app/import/session_file.h"
#include "ui/app/import/session_list.h"
#include "ui/app/view/upright.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// mm^2, in the scan's unit or the chosen one.
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

std::string nameOf(const fs::path& path) {
  const fs::path named = path.has_filename() ? path : path.parent_path();
  const fs::path stem = named.stem();
  return stem.extension() == ".nii" ? stem.stem().string() : stem.string();  // "ct.nii.gz"
}

Expected<BakeOptions> bakeOptionsFor(const fs::path& path, bool is_recipe, const PrepareOptions& asked) {
  BakeOptions out;
  out.unit = asked.unit;
  out.close = closeOptionsOf(asked.closing);
  if (asked.voxel_mm > 0) {
    out.voxelize.voxel_mm = asked.voxel_mm;
    out.voxel_is_given = true;
  } else if (!is_recipe) {
    KERF_TRY(area, areaOfScan(path, asked.unit));
    out.voxelize.voxel_mm = voxelFor(area);
  }
  return out;
}

struct Prepared {
  fs::path case_folder;
  std::vector<std::string> notes;
};

std::vector<std::string> notesOf(const CaseManifest& manifest) {
  std::vector<std::string> out = manifest.changes;
  out.push_back(phrase("voxel size {:g} mm", manifest.voxel_mm));
  for (const CaseSource& source : manifest.sources) {
    std::string line = phrase("unit {}: {}", source.unit, shownText(source.unit_reason));
    if (std::find(out.begin(), out.end(), line) == out.end()) out.push_back(std::move(line));
  }
  return out;
}

// Recipe of a label volume, below the data folder: users can read it there and bake it again.
Expected<fs::path> writeRecipe(const fs::path& volume, const OpeningOptions& options, const Progress& progress) {
  std::string text = options.prepare.recipe;
  if (text.empty()) {
    KERF_TRY(found, readLabels(volume, progress));
    KERF_TRY(materials, readDefaultMaterials());
    const LabelPlan plan(std::move(found), std::move(materials), options.prepare.voxel_mm);
    if (plan.isEmpty())
      return fail({.code = Error::Code::kEmpty,
                   .file = volume.string(),
                   .found = "labels, but none with the name of a tissue",
                   .expected = "at least one tissue",
                   .hint = "choose tissues in the import panel, or write a recipe (docs/reference/recipes.md)"});
    text = plan.recipe();
  }

  const fs::path folder = options.data_folder / "recipes";
  std::error_code failed;
  fs::create_directories(folder, failed);
  const std::string hash = sha256(std::as_bytes(std::span(text)));
  fs::path out = folder / fmt::format("{}-{}.toml", nameOf(volume), hash.substr(0, 8));
  KERF_TRY(file, AtomicFile::create(out));
  file.stream() << text;
  KERF_CHECK(file.commit());
  return out;
}

// Bakes a scan or a recipe below the data folder, or finds its earlier case there.
Expected<Prepared> prepare(const fs::path& path, const OpeningOptions& options, const Progress& progress) {
  const FileKind kind = kindOf(path);
  if (kind == FileKind::kLabels) {
    KERF_TRY(recipe, writeRecipe(path, options, partOf(progress, 0, 0.1)));
    OpeningOptions as_recipe = options;
    as_recipe.prepare = {};
    KERF_TRY(prepared, prepare(recipe, as_recipe, partOf(progress, 0.1, 1)));
    prepared.notes.push_back(phrase("baked with the recipe {}", recipe.string()));
    return std::move(prepared);
  }
  const bool is_recipe = kind == FileKind::kRecipe;
  KERF_TRY(hash, sha256OfFile(path));
  KERF_TRY(bake_options, bakeOptionsFor(path, is_recipe, options.prepare));

  const fs::path cases = options.data_folder / "cases";
  std::error_code failed;
  fs::create_directories(cases, failed);
  const std::string voxel =
      is_recipe && !bake_options.voxel_is_given ? "" : fmt::format("-{:g}", bake_options.voxelize.voxel_mm);
  const std::string unit = bake_options.unit.empty() ? "" : "-" + bake_options.unit;
  const std::string base = fmt::format("{}-{}{}{}", nameOf(path), hash.substr(0, 8), unit, voxel);

  Prepared out;
  Expected<BakeReport> baked;
  for (int n = 1; n < 100; ++n) {
    out.case_folder = cases / (base + (n > 1 ? fmt::format("-{}", n) : "") + ".case");
    const bool is_there = fs::exists(out.case_folder, failed);
    baked = is_recipe ? bakeRecipe(path, out.case_folder, bake_options, progress)
                      : bake({path}, out.case_folder, bake_options, progress);
    // A case of another Kerf version stays: sessions were cut from it.
    if (baked || !is_there || baked.error().code != Error::Code::kWriteFailed) break;
  }
  if (!baked) return fail(std::move(baked).error());

  out.notes = notesOf(baked->manifest);
  return out;
}

// ---- Neighbours

// The other jaw of a pair at its recorded path. None: it is missing or has changed.
std::optional<fs::path> partnerOf(const fs::path& case_folder, const CaseManifest& manifest) {
  if (!manifest.pair) return {};
  const fs::path partner = fs::absolute(case_folder).lexically_normal().parent_path() / manifest.pair->partner;
  const auto known = isCase(partner) ? readCaseManifest(partner) : tl::unexpected(Error{});
  if (!known || !known->pair || known->pair->frame != manifest.pair->frame) return {};
  return partner;
}

std::string freeName(const std::string& wanted, const std::string& first, const std::vector<CaseBeside>& others) {
  std::string out = wanted;
  const auto has = [&](const CaseBeside& other) { return other.name == out; };
  for (int n = 2; out == first || std::any_of(others.begin(), others.end(), has); ++n)
    out = fmt::format("{} {}", wanted, n);
  return out;
}

// All neighbours of a case, as cases; the partner of a jaw last.
Expected<std::vector<CaseBeside>> prepareBeside(const fs::path& case_folder, const CaseManifest& manifest,
                                                const OpeningOptions& options, const Progress& progress, Opened& out) {
  std::vector<CaseBeside> found;
  for (const OpenBeside& asked : options.beside) {
    const double n = static_cast<double>(found.size()), all = static_cast<double>(options.beside.size());
    KERF_TRY(folder, prepareToStandBeside(asked, options, out.notes, partOf(progress, n / all, (n + 1) / all)));
    const std::string name = asked.name.empty() ? nameOf(asked.path) : asked.name;
    found.push_back({folder, freeName(name, out.name, found)});
    out.sources_beside.push_back(asked.path);
  }

  const auto partner = partnerOf(case_folder, manifest);
  std::error_code ignored;
  const auto isPartner = [&](const CaseBeside& other) { return fs::equivalent(other.folder, *partner, ignored); };
  const auto isWithout = [&](const fs::path& folder) {
    const auto known = readCaseManifest(folder);
    return known && std::find(options.without.begin(), options.without.end(), known->id) != options.without.end();
  };
  if (partner && std::none_of(found.begin(), found.end(), isPartner) && !isWithout(*partner)) {
    found.push_back({*partner, freeName(nameOf(*partner), out.name, found)});
    out.sources_beside.push_back(*partner);
    out.notes.push_back(phrase("one jaw of a pair: {} is its neighbour, in occlusion", found.back().name));
  }
  return found;
}

// Notes the neighbours that hardly fit.
Expected<void> noteMisfits(const LiveRun& run, std::vector<std::string>& notes) {
  for (const LiveNeighbour& other : run.neighbours()) {
    KERF_TRY(solid, readCaseSolid(other.known.folder));
    if (auto note = misfitOf(*run.original(), run.caseManifest().box, other.known.name, solid))
      notes.push_back(std::move(*note));
  }
  return {};
}

}  // namespace

Expected<fs::path> prepareToStandBeside(const OpenBeside& asked, const OpeningOptions& options,
                                        std::vector<std::string>& notes, const Progress& progress) {
  const FileKind kind = kindOf(asked.path);
  if (kind == FileKind::kCase) return asked.path;
  if (kind == FileKind::kRun || kind == FileKind::kSessionFile || kind == FileKind::kTool)
    return fail({.code = Error::Code::kUnsupported,
                 .file = asked.path.string(),
                 .found = kind == FileKind::kTool ? "a tool" : "a session",
                 .expected = "a scan, a recipe or a case as neighbour",
                 .hint = "open the case of the session as neighbour"});

  OpeningOptions its_own = options;
  its_own.prepare = asked.prepare;
  KERF_TRY(prepared, prepare(asked.path, its_own, progress));
  for (const std::string& note : prepared.notes)
    notes.push_back((asked.name.empty() ? nameOf(asked.path) : asked.name) + ": " + note);
  return prepared.case_folder;
}

CloseOptions closeOptionsOf(const ClosingChoice& choice) {
  using Way = ClosingChoice::Way;
  CloseOptions out;
  switch (choice.way) {
    case Way::kAutomatic:
      out.mode = CloseMode::kAuto;
      break;
    case Way::kBase:
      out.mode = CloseMode::kBase;
      break;
    case Way::kHolesOnly:
      out.mode = CloseMode::kRepair;
      break;
    case Way::kWrap:
      out.mode = CloseMode::kWrap;
      break;
  }
  out.base_style = choice.is_full_base ? BaseStyle::kFull : BaseStyle::kHorseshoe;
  out.base_margin_mm = choice.base_mm;
  out.base_smoothing_mm = choice.smooth_mm;
  out.find_occlusal_plane = choice.follows_occlusal_plane;
  out.fill_up_to_mm = choice.holes_up_to_mm;
  out.wrap_alpha_mm = choice.wrap_mm;
  out.trim_rim_mm = choice.trim_rim_mm;
  out.trims = choice.trims;
  return out;
}

namespace {

// A recipe is TOML, too.
bool looksLikeTool(const fs::path& path) {
  constexpr std::size_t kMostBytes = 4096;
  std::error_code ignored;
  if (path.extension() != ".toml" || !fs::is_regular_file(path, ignored)) return false;
  std::ifstream in(path, std::ios::binary);
  std::string begin(kMostBytes, '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(in.gcount()));
  return begin.find("\"kerf-tool\"") != begin.npos;
}

}  // namespace

bool isFolderOfMeshes(const fs::path& path) {
  std::error_code ended;
  for (fs::directory_iterator file(path, ended), end; !ended && file != end; file.increment(ended)) {
    const MeshFormatRow* const format = formatOfExtension(file->path().extension().string());
    if (format && format->read) return true;
  }
  return false;
}

FileKind kindOf(const fs::path& path) {
  if (isRun(path)) return FileKind::kRun;
  if (isCase(path)) return FileKind::kCase;
  if (isSessionFile(path)) return FileKind::kSessionFile;
  if (looksLikeTool(path)) return FileKind::kTool;
  if (looksLikeRecipe(path)) return FileKind::kRecipe;
  // A picture in a folder of meshes is no slice.
  return isLabelVolume(path) && !isFolderOfMeshes(path) ? FileKind::kLabels : FileKind::kScan;
}

double voxelFor(double area_mm2) {
  constexpr double kTriangles = 8e5, kPerVoxel = 3.4;  // triangles per voxel of a scan's area, including the base
  const double voxel = std::sqrt(kPerVoxel * area_mm2 / kTriangles);
  return std::clamp(std::ceil(100 * voxel) / 100, 0.1, 0.25);
}

std::span<const char* const> demoNames() {
  static constexpr const char* kNames[] = {"molar", "mandible", "arch"};
  return kNames;
}

fs::path newSessionFolder(const fs::path& data_folder, const std::string& name) {
  const auto now = std::chrono::system_clock::now();
  const auto part = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()) % 1000;
  const std::string base = fmt::format("{}-{:%Y%m%d-%H%M%S}-{:03}", name,
                                       fmt::localtime(std::chrono::system_clock::to_time_t(now)), part.count());
  fs::path out = data_folder / "sessions" / (base + ".run");
  std::error_code ignored;
  for (int n = 2; fs::exists(out, ignored); ++n) out.replace_filename(fmt::format("{}-{}.run", base, n));
  return out;
}

namespace {

// Another run in the same folder with the same content. None: there is none.
std::optional<fs::path> sameRun(const fs::path& run_folder, const RunManifest& run) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(run_folder.parent_path(), ignored)) {
    const bool is_being_written = entry.path().filename().string().starts_with('.');
    if (entry.path() == run_folder || is_being_written || !isRun(entry.path())) continue;
    const auto other = readRunManifest(entry.path());
    if (!other || other->is_open || other->mode != run.mode || other->case_id != run.case_id) continue;
    const bool begins_alike = other->begin_sha256 == run.begin_sha256 && other->beside.size() == run.beside.size();
    if (begins_alike && other->state_hash == run.state_hash) return entry.path();
  }
  return {};
}

// A session of the data folder: its title is the user's name for it.
bool isOfData(const fs::path& run_folder, const fs::path& data_folder) {
  std::error_code failed;
  return fs::equivalent(fs::absolute(run_folder).lexically_normal().parent_path(), data_folder / "sessions", failed);
}

// Unpacks a session, or finds it from an earlier time.
Expected<Opened> openFileToCut(const fs::path& file, const OpeningOptions& options, const Progress& progress) {
  KERF_TRY(run, unpackSession(file, options.data_folder, partOf(progress, 0, 0.3)));
  KERF_TRY(manifest, readRunManifest(run));
  const auto known = sameRun(run, manifest);
  std::error_code ignored;
  if (known) fs::remove_all(run, ignored);
  KERF_TRY(opened, openToCut(known.value_or(run), options, partOf(progress, 0.3, 1)));
  opened.source = file;
  opened.name = nameOf(file);
  return std::move(opened);
}

}  // namespace

std::string tellRecovery(const Recovery& recovery) {
  const Replay& replay = recovery.replay;
  std::string out = phrase("recovered {:.1f} s, {:.3f} mm3 removed", recovery.manifest.duration_s, replay.removed_mm3);
  if (replay.first_tick > 0)
    out += "\n" + phrase("Checkpoint at {:.1f} s", kTick * static_cast<double>(replay.first_tick));
  if (!replay.note.empty()) out += "\n" + replay.note;
  if (!replay.is_same && replay.checks > 0) out += "\n" + phrase("It differs from the recording: check it before use");
  return out;
}

Expected<Opened> openToCut(const fs::path& path, const OpeningOptions& options, const Progress& progress) {
  if (isSessionFile(path)) return openFileToCut(path, options, progress);
  Opened out;
  out.name = nameOf(path);
  out.source = path;
  const FileKind kind = kindOf(path);
  fs::path case_folder = path;
  if (kind == FileKind::kRun) {
    KERF_TRY(before, readRunManifest(path));
    if (before.is_open) {
      KERF_TRY(recovered, recoverRun(path, partOf(progress, 0, 0.3)));
      out.notes.push_back(phrase("This session was not ended.") + "\n" + tellRecovery(recovered));
    }
    KERF_TRY(folder, caseOfRun(path));
    case_folder = folder;
    out.name = isOfData(path, options.data_folder) ? sessionTitle(path) : nameOf(fs::path(before.case_path));
  } else if (kind != FileKind::kCase) {
    KERF_TRY(prepared, prepare(path, options, partOf(progress, 0, options.beside.empty() ? 0.7 : 0.4)));
    case_folder = prepared.case_folder;
    out.notes = std::move(prepared.notes);
    out.prepared = options.prepare;
  }

  KERF_TRY(manifest, readCaseManifest(case_folder));
  KERF_TRY(solid, readCaseSolid(case_folder));
  out.occlusal = occlusalSideOf(solid);

  LiveRunOptions live;
  live.tools = options.coming_tools.valid() ? options.coming_tools.get() : options.tools;
  live.haptic.real_time = options.real_time;
  live.is_looked_at = true;
  if (kind == FileKind::kRun) live.from = path;
  // The neighbours of a run come back by themselves, the partner of a jaw among them.
  const CaseManifest alone = [&] {
    CaseManifest copy = manifest;
    if (kind == FileKind::kRun) copy.pair.reset();
    return copy;
  }();
  KERF_TRY(beside, prepareBeside(case_folder, alone, options, partOf(progress, 0.4, 0.7), out));
  live.beside = std::move(beside);
  live.without = options.without;
  live.is_felt = options.coupling.has_value();
  if (options.coupling)
    live.step.coupling = *options.coupling;
  else
    live.haptic.stall_ms = 5000;  // no arm to protect: a busy machine need not stop the tool
  live.start = {Eigen::Quaterniond::Identity(), manifest.box.center() + Vec3d(0, 0, manifest.box.size()[2])};
  KERF_TRY(run, LiveRun::open(case_folder, newSessionFolder(options.data_folder, out.name), std::move(live),
                              partOf(progress, 0.7, 0.9)));
  if (!report(progress, 0.9, "measuring distances to pulp and nerve")) return cancelled();
  KERF_TRY(structures, Structures::of(run->object(), partOf(progress, 0.9, 1)));
  run->thread().watchHeatOf(structures);
  out.structures = std::move(structures);
  KERF_TRY(neighbours, neighbourFields(*run, partOf(progress, 0.92, 1)));
  out.neighbours = std::move(neighbours);
  KERF_CHECK(noteMisfits(*run, out.notes));
  if (kind == FileKind::kRun)
    out.notes.push_back(
        phrase("Continues {} in a new session: {:.3f} mm3 removed before. Undo goes back to this point.",
               path.filename().string(), run->removedBefore()));
  out.run = std::move(run);
  return out;
}

Expected<Opened> openBranchToCut(const fs::path& run_folder, const BranchPoint& point, const OpeningOptions& options,
                                 const Progress& progress) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  const fs::path branch = newSessionFolder(options.data_folder, nameOf(fs::path(manifest.case_path)));
  std::error_code ignored;
  fs::create_directories(branch.parent_path(), ignored);
  KERF_TRY(written, branchRun(run_folder, point, branch, partOf(progress, 0, 0.5)));

  // Drops a branch without a session, and a second branch of the same moment.
  const auto known = sameRun(branch, written);
  if (known) fs::remove_all(branch, ignored);
  auto opened = openToCut(known.value_or(branch), options, partOf(progress, 0.5, 1));
  if (!opened && !known) fs::remove_all(branch, ignored);
  return opened;
}

namespace {

// The file of a demo, made if missing.
Expected<fs::path> makeDemo(const std::string& name, const fs::path& data_folder, const Progress& progress) {
  const fs::path folder = data_folder / "demo" / name;
  const std::string manifest = name + (name == "arch" ? ".ply" : ".toml");
  std::error_code ignored;
  if (fs::exists(folder / manifest, ignored)) return folder / manifest;

  std::error_code failed;
  fs::create_directories(folder.parent_path(), failed);
  if (failed)
    return fail({.code = Error::Code::kWriteFailed,
                 .file = folder.parent_path().string(),
                 .place = "folder",
                 .found = failed.message(),
                 .expected = "a writable folder",
                 .hint = "use another --data FOLDER, or change the permissions"});
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

}  // namespace

Expected<Opened> openDemoToCut(const std::string& name, const OpeningOptions& options, const Progress& progress) {
  KERF_TRY(path, makeDemo(name, options.data_folder, partOf(progress, 0, 0.3)));
  return openToCut(path, options, partOf(progress, 0.3, 1));
}

}  // namespace kerf
