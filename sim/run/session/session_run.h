// The run folder of a person's session: contents before its first tick, and after its end.
//
// Before the first tick: run.toml, marked as open; tools/ with all tools of the session; the lock. During the session:
// session.kerflog grows. At the end: run.vdb, and run.toml once more. A killed program leaves the folder open:
// recoverRun() replays the log and does the rest. Nothing is ever deleted here but checkpoints.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/case/case_bundle.h"
#include "geometry/tool/tool.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/report/replay.h"
#include "sim/session/session.h"
#include "sim/session/session_log.h"

namespace kerf {

/// A tool of a session, and its source file.
struct SessionTool {
  std::filesystem::path file;
  Tool tool;
  bool is_damaged = false;  ///< `file`, in the run it comes from, is damaged: it is not copied
};

/// Held while a program works on a run folder. The system releases it whenever the program ends.
class RunLock {
 public:
  /// Error kUnsupported: another program holds it. kWriteFailed: the folder cannot be written to.
  static Expected<RunLock> take(const std::filesystem::path& run_folder);
  RunLock(RunLock&& other) noexcept;
  RunLock& operator=(RunLock&&) = delete;
  ~RunLock();

 private:
  explicit RunLock(int file) : file_(file) {}
  int file_ = -1;
};

/// A neighbour of the case.
struct SessionNeighbour {
  std::filesystem::path folder;
  CaseManifest manifest;
  std::string name;        ///< for display: "35"
  bool has_begin = false;  ///< it also stood in the continued run
  double removed_mm3 = 0;  ///< removed volume in that run
};

struct OpenedRun {
  RunManifest manifest;  ///< open
  RunLock lock;
};
/// Makes the folder, which must not exist, with tools and manifest. The folder of the case may be anywhere; the run
/// stores its path. Deletes the folder after an error.
/// @param from  an ended run of the same case to continue: copies its field. Empty: none.
/// @param beside  in the order of the session's objects; those with a begin come first, as in `from`.
Expected<OpenedRun> openSessionRun(const std::filesystem::path& run_folder, const std::filesystem::path& case_folder,
                                   const CaseManifest& manifest, std::span<const SessionTool> tools,
                                   const std::filesystem::path& from = {},
                                   std::span<const SessionNeighbour> beside = {});
/// The log header's values for case and tools; describe() adds the rest.
SessionHeader sessionHeader(const RunManifest& manifest);

/// Label of a piece, set by the user.
struct PieceLabel {
  std::string name;    ///< empty: numbered
  std::string colour;  ///< "sky": from the window's palette; empty: the colours of its tissues
  bool operator==(const PieceLabel&) const = default;
};
/// By CutObject::id.
using PieceLabels = std::map<std::uint32_t, PieceLabel>;

/// Stores names and colours beside the log, for recoverRun(): no other file has them before the end. Written whole or
/// not at all. Error kWriteFailed.
Expected<void> writePieceLabels(const std::filesystem::path& run_folder, const PieceLabels& labels);

/// The labels last written; for an object in one piece no other file has them, even after the end. Empty: none, or a
/// damaged file.
PieceLabels readPieceLabels(const std::filesystem::path& run_folder);

/// Ends a session: writes the field, then the manifest, no longer open. Pieces are written as one field, each where it
/// was loaded; the manifest has their places. Also counts and writes cuts of neighbours; each neighbour's pieces are
/// one field.
/// @param loaded  the case's field, if the session continued a run; null: as loaded by the session.
/// @param beside  the same for the neighbours, in their order; missing ones: as loaded by the session.
/// Error kEmpty: nothing was changed, and nothing is written.
Expected<void> endSessionRun(const std::filesystem::path& run_folder, const Session& session, RunManifest& manifest,
                             const PieceLabels& labels = {}, const BrickField* loaded = nullptr,
                             std::span<const BrickField* const> beside = {});

struct Recovery {
  RunManifest manifest;
  Replay replay;  ///< its note lists the log's defects
};
/// Ends a session of a killed program, from its log: up to the last whole record, at most a second before the end. For
/// an ended session it rewrites a damaged run.vdb, if the log leads to the state in run.toml.
/// Errors: kUnsupported for a run that is no session, has ended and is whole, or is open in another program; kEmpty
/// when nothing is cut at its end: its log has the undone steps, see droppedSteps() in run_branch.h; those of
/// replayRun().
/// Starts from the newest usable checkpoint (checkpoint.h); the replay's note names one that it had to leave out.
/// @cost  seconds; without a checkpoint at most the session's time, usually 2 to 25 % of it.
Expected<Recovery> recoverRun(const std::filesystem::path& run_folder, const Progress& progress = {});

namespace internal {

/// Ids of the tools that were in hand, in the order of their first use: RunManifest::tool_id.
std::string toolsInHand(const SessionLog& log, const RunManifest& manifest);

/// Names and colours: for an ended session in pieces from the manifest.
PieceLabels labelsOf(const std::filesystem::path& run_folder, const RunManifest& manifest);

/// Input of endSessionRun() for cases that an earlier run cut: their fields before that run.
struct FieldsBefore {
  std::optional<BrickField> of_case;                         ///< none: the session began with the case
  std::vector<std::unique_ptr<const BrickField>> of_others;  ///< of neighbours cut before
  std::vector<const BrickField*> beside;                     ///< one each, null: as loaded by the session
  const BrickField* loaded() const { return of_case ? &*of_case : nullptr; }
};
Expected<FieldsBefore> fieldsBefore(const std::filesystem::path& run_folder, const RunManifest& manifest);

/// Copies the tools of a session into its existing folder. Returns the manifest, open and not yet written. For the
/// parameters see openSessionRun().
Expected<RunManifest> storeSession(const std::filesystem::path& run_folder, const std::filesystem::path& case_folder,
                                   const CaseManifest& manifest, std::span<const SessionTool> tools,
                                   std::span<const SessionNeighbour> beside);

/// As endSessionRun(), but also writes an unchanged session that continues a run. Error kEmpty: it began with the case,
/// and nothing differs from that.
Expected<void> writeEnd(const std::filesystem::path& run_folder, const Session& session, RunManifest& manifest,
                        const PieceLabels& labels, const BrickField* loaded, std::span<const BrickField* const> beside);

}  // namespace internal

}  // namespace kerf
