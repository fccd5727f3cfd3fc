// The run folder of a person's session: what is written before its first tick, and what when it has ended.
//
// Before the first tick: run.toml, which says that the session is open; tools/ with all tools of the session; the lock.
// During it: session.kerflog grows. At the end: run.vdb, and run.toml once more. A program that is killed leaves the
// folder open: recoverRun() replays the log and does the rest. Nothing is ever deleted here.
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
#include "sim/run/replay.h"
#include "sim/run/run_manifest.h"
#include "sim/session/session.h"
#include "sim/session/session_log.h"

namespace kerf {

/// A tool of a session, and the file it was read from.
struct SessionTool {
  std::filesystem::path file;
  Tool tool;
  bool is_damaged = false;  ///< `file` is, in the run that it comes from: it is not copied
};

/// Held as long as a program works on a run folder. The system lets go of it when the program is gone, however.
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

/// A case that stands beside the one that is worked on.
struct SessionNeighbour {
  std::filesystem::path folder;
  CaseManifest manifest;
  std::string name;        ///< for people: "35"
  bool has_begin = false;  ///< it stood in the run that is gone on from, too
  double removed_mm3 = 0;  ///< off it, in that run
};

struct OpenedRun {
  RunManifest manifest;  ///< open
  RunLock lock;
};
/// Makes the folder, which must not exist, with tools and manifest. The folder of the case may be anywhere; the run
/// notes the way to it. After an error it is gone again.
/// @param from  a run of the same case that has ended, from which this one goes on: its field is copied. Empty: none.
/// @param beside  in the order of the session's objects; those that have a begin stand first, as in `from`.
Expected<OpenedRun> openSessionRun(const std::filesystem::path& run_folder, const std::filesystem::path& case_folder,
                                   const CaseManifest& manifest, std::span<const SessionTool> tools,
                                   const std::filesystem::path& from = {},
                                   std::span<const SessionNeighbour> beside = {});
/// What the header of its log says of case and tools; describe() says the rest.
SessionHeader sessionHeader(const RunManifest& manifest);

/// What a person said of a piece.
struct PieceLabel {
  std::string name;    ///< empty: it is numbered
  std::string colour;  ///< "sky": of a palette that the window has; empty: that of its tissues
  bool operator==(const PieceLabel&) const = default;
};
/// By CutObject::id.
using PieceLabels = std::map<std::uint32_t, PieceLabel>;

/// Keeps names and colours beside the log, for recoverRun(): they are in no other file before the end. Written whole or
/// not at all. Error kWriteFailed.
Expected<void> writePieceLabels(const std::filesystem::path& run_folder, const PieceLabels& labels);

/// As they were written last: of an object in one piece they stand nowhere else after the end, either. Empty: there are
/// none, or the file is damaged.
PieceLabels readPieceLabels(const std::filesystem::path& run_folder);

/// Ends a session: writes the field, then the manifest, which is then no longer open. Pieces are written as one field,
/// each where it was loaded; the manifest says where they are.
/// What was cut off cases beside is counted and written, too: their pieces, if there are any, are one field of theirs.
/// @param loaded  the case's field, if the session went on from another run; null: what the session has loaded.
/// @param beside  the same of the cases beside, in their order; fewer: what the session has loaded.
/// Error kEmpty: nothing was changed, and nothing is written.
Expected<void> endSessionRun(const std::filesystem::path& run_folder, const Session& session, RunManifest& manifest,
                             const PieceLabels& labels = {}, const BrickField* loaded = nullptr,
                             std::span<const BrickField* const> beside = {});

struct Recovery {
  RunManifest manifest;
  Replay replay;  ///< its note says what the log lacks
};
/// Ends a session whose program is gone, from its log: to the last whole record, at most a second before the end.
/// Of a session that has ended it writes a damaged run.vdb anew, if the log leads to the state that run.toml names.
/// Errors: kUnsupported for a run that is no session, has ended and is whole, or is open in another program; kEmpty
/// when nothing is cut at its end, what was taken back is in its log: droppedSteps() in run_branch.h; those of
/// replayRun().
/// @cost  as the session took, or less: about a quarter of it.
Expected<Recovery> recoverRun(const std::filesystem::path& run_folder, const Progress& progress = {});

namespace internal {

/// Ids of the tools that were in hand, in the order of their first use: RunManifest::tool_id.
std::string toolsInHand(const SessionLog& log, const RunManifest& manifest);

/// Names and colours: of an ended session in pieces the manifest has them.
PieceLabels labelsOf(const std::filesystem::path& run_folder, const RunManifest& manifest);

/// What endSessionRun() asks for of cases that an earlier run had cut: their fields, as they were before that.
struct FieldsBefore {
  std::optional<BrickField> of_case;                         ///< none: the session began with the case
  std::vector<std::unique_ptr<const BrickField>> of_others;  ///< of those beside it that had been cut
  std::vector<const BrickField*> beside;                     ///< one each, null: as the session has loaded it
  const BrickField* loaded() const { return of_case ? &*of_case : nullptr; }
};
Expected<FieldsBefore> fieldsBefore(const std::filesystem::path& run_folder, const RunManifest& manifest);

/// Copies the tools of a session into its folder, which exists. The manifest is returned, open, and not written.
/// For the parameters see openSessionRun().
Expected<RunManifest> storeSession(const std::filesystem::path& run_folder, const std::filesystem::path& case_folder,
                                   const CaseManifest& manifest, std::span<const SessionTool> tools,
                                   std::span<const SessionNeighbour> beside);

/// As endSessionRun(), and of a session that goes on from a run also when it is as that one was left.
/// Error kEmpty: it began with the case, and nothing differs from that.
Expected<void> writeEnd(const std::filesystem::path& run_folder, const Session& session, RunManifest& manifest,
                        const PieceLabels& labels, const BrickField* loaded, std::span<const BrickField* const> beside);

}  // namespace internal

}  // namespace kerf
