#include "sim/run/session/session_run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <set>
#include <system_error>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/base/toml_reader.h"
#include "geometry/base/version.h"
#include "geometry/field/vdb_io.h"
#include "geometry/tool/tool_file.h"
#include "sim/monitor/monitor.h"
#include "sim/pieces/joined_field.h"
#include "sim/run/export/placed_pieces.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_output.h"
#include "sim/run/scene/load_scene.h"
#include "sim/run/session/added_materials.h"
#include "sim/run/session/run_branch.h"
#include "sim/run/session/session_pieces.h"
#include "sim/session/checkpoint.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr const char* kLock = "lock";
constexpr const char* kToolFolder = "tools";
constexpr const char* kPieceNames = "piece-names.toml";
constexpr const char* kColours = "colours";  // a table in it

tl::unexpected<Error> cannotWrite(const fs::path& what, const std::string& why) {
  return fail({.code = Error::Code::kWriteFailed,
               .file = what.string(),
               .found = why,
               .expected = "a writable place with room",
               .hint = "another folder, or free some space"});
}

tl::unexpected<Error> nothingCut(const fs::path& run_folder) {
  return fail({.code = Error::Code::kEmpty,
               .file = run_folder.string(),
               .found = "the session has no cuts",
               .expected = "at least one stroke that is not undone",
               .hint = "delete the folder if you do not need it"});
}

// Copies tool n, with the file it names, into a folder of its own, since names may repeat. Hashes before copying: see
// finishRun().
Expected<RunManifest::ToolFile> storeTool(const SessionTool& tool, std::size_t n, const fs::path& run_folder) {
  const std::string folder = fmt::format("{}/{:02}", kToolFolder, n + 1);
  RunManifest::ToolFile out{tool.tool.id, folder + "/" + tool.file.filename().string(), {}};
  if (tool.is_damaged) return out;
  KERF_TRY(hash, sha256OfFile(tool.file));
  out.sha256 = hash;
  std::error_code failed;
  fs::create_directories(run_folder / folder, failed);
  if (failed) return cannotWrite(run_folder / folder, failed.message());
  KERF_CHECK(copyFile(tool.file, run_folder / out.file));
  if (const fs::path& beside = tool.tool.companion; !beside.empty())
    KERF_CHECK(copyFile(beside, run_folder / folder / beside.filename()));
  return out;
}

using internal::Objects;

bool hasMoved(const CutObject& object) {
  RunManifest::Piece piece;
  piece.T_case_piece = object.T_world_object;
  return piece.isMoved();
}

// Differences of all pieces together from the case.   @param fields  of the pieces; none: of one whole object.
BrickField changesOf(const Objects& objects, const std::vector<BrickField>& fields, const BrickField* loaded) {
  if (fields.empty()) return objects.front()->bricks().changedField();
  std::vector<FieldPart> parts;
  parts.reserve(fields.size());
  for (const BrickField& field : fields) parts.push_back({.begin = &field});
  return joinedChanges(loaded ? *loaded : objects.front()->baked().phi0(), parts);
}

// Neighbours: the difference of each from its case, and its removed volume from the ledger.
struct NeighbourChanges {
  std::vector<BrickField> fields;
  std::vector<double> removed_mm3;
  bool isEmpty() const {
    return std::all_of(fields.begin(), fields.end(), [](const BrickField& field) { return field.isEmpty(); });
  }
};
NeighbourChanges changesBeside(const Session& session, std::span<const BrickField* const> loaded) {
  NeighbourChanges out;
  for (std::size_t n = 1; n < session.loaded().size(); ++n) {
    const Objects objects = internal::objectsOf(session, n);
    const BrickField* const before = n <= loaded.size() ? loaded[n - 1] : nullptr;
    const bool is_joined = before || internal::isInPieces(objects);
    out.fields.push_back(
        changesOf(objects, is_joined ? internal::fieldsOf(objects) : std::vector<BrickField>{}, before));

    double& removed = out.removed_mm3.emplace_back(0);
    for (const CutObject* object : objects)
      for (std::size_t m = 0; m < object->removed_mm3.size(); ++m)
        removed += object->removed_before_mm3[m] + object->removed_mm3[m];
  }
  return out;
}

}  // namespace

// ---- The lock

Expected<RunLock> RunLock::take(const fs::path& run_folder) {
  const fs::path file = run_folder / kLock;
  const int fd = ::open(file.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
  if (fd < 0) return cannotWrite(file, std::system_category().message(errno));

  RunLock out(fd);
  if (::flock(fd, LOCK_EX | LOCK_NB) == 0) return out;
  return fail({.code = Error::Code::kUnsupported,
               .file = run_folder.string(),
               .found = "the session is open in another program",
               .expected = "a session that no program uses",
               .hint = "end it in that program"});
}

RunLock::RunLock(RunLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
RunLock::~RunLock() {
  if (file_ >= 0) ::close(file_);
}

// ---- Beginning and end

Expected<RunManifest> internal::storeSession(const fs::path& run_folder, const fs::path& case_folder,
                                             const CaseManifest& manifest, std::span<const SessionTool> tools,
                                             std::span<const SessionNeighbour> beside) {
  RunManifest out;
  out.kerf_version = kVersion;
  KERF_TRY(case_path, internal::relativeCasePath(case_folder, run_folder));
  out.case_path = case_path;
  out.case_id = manifest.id;
  out.mode = kModeSession;
  out.voxel_mm = manifest.voxel_mm;
  out.is_open = true;
  for (const SessionNeighbour& other : beside) {
    KERF_TRY(path, internal::relativeCasePath(other.folder, run_folder));
    out.beside.push_back({.case_path = path,
                          .case_id = other.manifest.id,
                          .voxel_mm = other.manifest.voxel_mm,
                          .removed_mm3 = other.removed_mm3,
                          .has_begin = other.has_begin,
                          .name = other.name});
  }

  for (std::size_t n = 0; n < tools.size(); ++n) {
    KERF_TRY(stored, storeTool(tools[n], n, run_folder));
    out.tools.push_back(std::move(stored));
  }
  out.tool_id = out.tools.empty() ? "" : out.tools.front().id;
  return out;
}

Expected<OpenedRun> openSessionRun(const fs::path& run_folder, const fs::path& case_folder,
                                   const CaseManifest& manifest, std::span<const SessionTool> tools,
                                   const fs::path& from, std::span<const SessionNeighbour> beside) {
  std::error_code failed;
  if (!fs::create_directory(run_folder, failed) || failed)
    return fail({.code = Error::Code::kWriteFailed,
                 .file = run_folder.string(),
                 .found = failed ? failed.message() : "the name exists already",
                 .expected = "a new folder in a writable one",
                 .hint = "another name or place"});

  // The lock first: readers take a folder with a manifest and without a lock for one of a killed program.
  auto opened = [&]() -> Expected<OpenedRun> {
    KERF_TRY(lock, RunLock::take(run_folder));
    KERF_TRY(out, internal::storeSession(run_folder, case_folder, manifest, tools, beside));
    if (!from.empty()) {
      KERF_TRY(hash, internal::storeBegin(from, run_folder));
      out.begin_sha256 = hash;
    }
    KERF_CHECK(syncTree(run_folder));  // its files are on disk before the manifest
    KERF_CHECK(writeRunManifest(run_folder, out));
    return OpenedRun{std::move(out), std::move(lock)};
  }();
  if (!opened) fs::remove_all(run_folder, failed);
  return opened;
}

SessionHeader sessionHeader(const RunManifest& manifest) {
  SessionHeader out{{"kerf_version", kVersion}, {"case_id", manifest.case_id}};
  for (const RunManifest::ToolFile& tool : manifest.tools) {
    out.emplace_back("tool", tool.id);
    out.emplace_back("tool_sha256", tool.sha256);
  }
  for (std::size_t n = 1; n <= manifest.beside.size(); ++n)
    out.emplace_back(internal::neighbourKey(n), manifest.beside[n - 1].case_id);
  return out;
}

Expected<void> endSessionRun(const fs::path& run_folder, const Session& session, RunManifest& manifest,
                             const PieceLabels& labels, const BrickField* loaded,
                             std::span<const BrickField* const> beside) {
  // A continued session without undo steps is unchanged.
  if (loaded && !session.hasSteps()) return nothingCut(run_folder);
  return internal::writeEnd(run_folder, session, manifest, labels, loaded, beside);
}

Expected<void> internal::writeEnd(const fs::path& run_folder, const Session& session, RunManifest& manifest,
                                  const PieceLabels& labels, const BrickField* loaded,
                                  std::span<const BrickField* const> beside) {
  const Objects objects = internal::objectsOf(session, 0);
  const bool is_moved = std::any_of(objects.begin(), objects.end(), [](const auto* o) { return hasMoved(*o); });
  const bool is_in_pieces = internal::isInPieces(objects) || is_moved;
  const std::vector<BrickField> fields =
      is_in_pieces || loaded ? internal::fieldsOf(objects) : std::vector<BrickField>{};

  const BrickField changed = changesOf(objects, fields, loaded);
  const NeighbourChanges others = changesBeside(session, beside);
  if (!loaded && changed.isEmpty() && !is_moved && others.isEmpty()) return nothingCut(run_folder);

  KERF_TRY(added_before, readBeginMaterials(run_folder, manifest));
  KERF_TRY(table, readDefaultMaterials());
  const MaterialBricks added = addedMaterials(objects, added_before, table);

  const fs::path field = run_folder / internal::kRunField;
  std::vector<NamedField> grids{{"phi", &changed}};
  for (std::size_t n = 0; n < others.fields.size(); ++n) grids.push_back({neighbourId(n + 1), &others.fields[n]});
  KERF_CHECK(writeVdb(field, grids, {{"case_id", manifest.case_id}}, &added));
  KERF_TRY(hash, sha256OfFile(field));
  manifest.field_sha256 = hash;
  // Rounding must not make a manifest that its reader rejects. An ended session counts these already.
  for (std::size_t n = 0; manifest.is_open && n < manifest.beside.size(); ++n)
    manifest.beside[n].removed_mm3 = std::max(manifest.beside[n].removed_mm3 + others.removed_mm3[n], 0.0);
  const auto is_named = [&](const CutObject* object) {
    const auto label = labels.find(object->id);
    return label != labels.end() && isNamedByUser(label->second.name);
  };
  if (is_in_pieces)
    manifest.pieces = internal::piecesOf(objects, fields, labels);
  else if (is_named(objects.front()))
    manifest.pieces = internal::piecesOf(objects, internal::fieldsOf(objects), labels);
  else
    manifest.pieces.clear();
  manifest.duration_s = static_cast<double>(session.state().tick) * kTick;
  manifest.state_hash = fmt::format("{:016x}", session.hash());
  manifest.is_open = false;
  return writeRunManifest(run_folder, manifest);
}

// [colours] is separate: an older Kerf reads the names and ignores it.
Expected<void> writePieceLabels(const fs::path& run_folder, const PieceLabels& labels) {
  toml::table names, colours;
  for (const auto& [id, label] : labels) {
    if (!label.name.empty()) names.insert(std::to_string(id), label.name);
    if (!label.colour.empty()) colours.insert(std::to_string(id), label.colour);
  }
  if (!colours.empty()) names.insert(kColours, std::move(colours));
  KERF_TRY(file, AtomicFile::create(run_folder / kPieceNames));
  file.stream() << "# Names and colours of the pieces, by their number in the session.\n" << names << "\n";
  return file.commit();
}

namespace {

std::optional<std::uint32_t> numberOf(std::string_view word) {
  std::uint32_t out = 0;
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), out);
  if (failed != std::errc{} || end != word.data() + word.size()) return {};
  return out;
}

}  // namespace

// Labels are optional: without the file, or with a damaged one, pieces are numbered.
PieceLabels readPieceLabels(const fs::path& run_folder) {
  PieceLabels out;
  const auto table = parseToml(run_folder / kPieceNames);
  if (!table) return out;
  for (const auto& [key, node] : *table)
    if (const auto id = numberOf(key.str()); id && node.is_string()) out[*id].name = *node.value<std::string>();
  if (const toml::table* const colours = (*table)[kColours].as_table())
    for (const auto& [key, node] : *colours)
      if (const auto id = numberOf(key.str()); id && node.is_string()) out[*id].colour = *node.value<std::string>();
  return out;
}

PieceLabels internal::labelsOf(const fs::path& run_folder, const RunManifest& manifest) {
  PieceLabels out = readPieceLabels(run_folder);
  for (const RunManifest::Piece& piece : manifest.pieces) out[piece.id] = {piece.name, piece.colour};
  return out;
}

// ---- Recovery

std::string internal::toolsInHand(const SessionLog& log, const RunManifest& manifest) {
  std::string out = manifest.tools.front().id;
  std::set<std::size_t> known{0};
  for (const SessionEvent& event : log.events) {
    const auto* text = std::get_if<SessionCommand>(&event.what);
    if (!text) continue;
    const auto command = parseCommand(text->text);
    const auto* select = command ? std::get_if<SelectTool>(&*command) : nullptr;
    if (select && select->tool < manifest.tools.size() && known.insert(select->tool).second)
      out += ", " + manifest.tools[select->tool].id;
  }
  return out;
}

Expected<internal::FieldsBefore> internal::fieldsBefore(const fs::path& run_folder, const RunManifest& manifest) {
  FieldsBefore out;
  if (manifest.begin_sha256.empty()) return out;
  KERF_TRY(case_folder, caseOfRun(run_folder));
  KERF_TRY(field, readCaseField(case_folder));
  out.of_case = std::move(field);

  KERF_TRY(folders, casesBesideRun(run_folder));
  for (std::size_t n = 0; n < folders.size(); ++n) {
    out.beside.push_back(nullptr);
    if (!manifest.beside[n].has_begin) continue;
    KERF_TRY(other, readCaseField(folders[n]));
    out.beside.back() = out.of_others.emplace_back(std::make_unique<const BrickField>(std::move(other))).get();
  }
  return out;
}

Expected<Recovery> recoverRun(const fs::path& run_folder, const Progress& progress) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  const bool has_ended = !manifest.is_open;
  const bool is_whole = has_ended && requireSha256(run_folder / internal::kRunField, manifest.field_sha256, "");
  if (manifest.mode != kModeSession || is_whole)
    return fail({.code = Error::Code::kUnsupported,
                 .file = run_folder.string(),
                 .found = manifest.mode == kModeSession ? "an ended session" : "mode " + manifest.mode,
                 .expected = "a session without a running program",
                 .hint = "its data is complete: kerf export " + run_folder.string()});
  const auto lock = RunLock::take(run_folder);
  if (!lock) return fail(lock.error());

  KERF_TRY(before, internal::fieldsBefore(run_folder, manifest));

  Recovery out;
  Expected<void> ended;
  bool has_dropped = false;
  const auto end = [&](const Session& session, const SessionLog& log) {
    has_dropped = !droppedSteps(log).empty();
    if (has_ended && fmt::format("{:016x}", session.hash()) != manifest.state_hash) {
      ended = fail({.code = Error::Code::kUnsupported,
                    .file = (run_folder / internal::kRunField).string(),
                    .found = "it is damaged, and the log leads to another state than the one in run.toml",
                    .expected = "a complete log of this run",
                    .hint = "restore it from a copy"});
      return;
    }
    manifest.tool_id = internal::toolsInHand(log, manifest);
    ended = endSessionRun(run_folder, session, manifest, internal::labelsOf(run_folder, manifest), before.loaded(),
                          before.beside);
  };
  const auto checkpoints = has_ended ? std::vector<fs::path>{} : findCheckpoints(run_folder);
  KERF_TRY(replayed, internal::replayRun(run_folder, manifest, progress, end, kToTheEnd, 0, checkpoints));
  if (!ended && ended.error().code == Error::Code::kEmpty && has_dropped)
    ended.error().hint =
        "its log still holds the undone steps: session.recover in the window saves them as separate runs";
  KERF_CHECK(ended);
  removeCheckpoints(run_folder);
  if (has_ended)
    replayed.note = fmt::format("{} was damaged: rebuilt from the log{}{}", internal::kRunField,
                                replayed.note.empty() ? "" : "; ", replayed.note);
  out.manifest = std::move(manifest);
  out.replay = std::move(replayed);
  return out;
}

}  // namespace kerf
