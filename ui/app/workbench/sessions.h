// Opens documents for cutting, ends their sessions, and reopens a document in a new session.
//
// A session's log names its tools, cases and coupling at its start. A new tool, neighbour, device or branch therefore
// ends the session and continues in another one: reopen().
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "sim/run/report/run_report.h"
#include "ui/app/document/part.h"
#include "ui/app/import/opening.h"
#include "ui/app/workbench/steps.h"

namespace kerf {

class Workbench;

/// Result of ending a session.
struct EndedSession {
  Expected<RunManifest> run;
  std::optional<RunReport> report{};
  /// If the session holds no steps: runs of the undone steps, by BranchPoint::step_began.
  std::map<std::uint64_t, std::filesystem::path> saved{};
  std::optional<Error> failed{};  ///< a failed save: the session folder with its log remains

  bool isWritten() const { return run.has_value(); }
  /// The log holds the cuts. False for a session without any.
  bool hasFailed() const { return failed || (!run && run.error().code != Error::Code::kEmpty); }
};

/// What the user sees after a session: its numbers and the way back to it.
struct Debrief {
  std::string text;
  std::filesystem::path folder;
};

/// Window thread only.
class Sessions final : public Part {
 public:
  explicit Sessions(Workbench& bench) : bench_(bench) {}

  /// Opens a case, or bakes a mesh first with the default remedies and lists their changes in a notice. Closes the open
  /// document.
  void open(const std::filesystem::path& path);
  /// Kerf's own anatomy, made at the first request.   @param name  of demoNames().
  void openDemo(const std::string& name);
  /// Opens the case of a session, with its neighbours, without the cuts. The session stays.
  void startOver(const std::filesystem::path& run_folder);
  /// Opens the first file for cutting and the others as neighbours, at their scan positions: each a scan, prepared with
  /// the default remedies, a recipe or a case. Tools among them go into the rack. A single file: as Imports::begin().
  /// To let the user decide first: Imports::beginAll().
  void openAll(const std::vector<std::filesystem::path>& paths);
  /// Prepares the scan of the open document again with smaller voxels and opens it in place of the session, without its
  /// cuts. The session stays in the list. A job. Without Tools::finerVoxels(): no effect.
  void prepareFiner(double voxel_mm);
  /// Ends the session and writes the run to Document::sessionFolder(). A job.
  void close();
  /// Writes the present state of the session to one file, NAME.kerf, while it goes on (saveSession()). A job. Replaces
  /// the file. Adds a missing ending to the name.
  void saveAs(const std::filesystem::path& path);
  /// The file of the open document: of saveAs(), or the opened one. Empty: not saved to a file yet.
  const std::filesystem::path& savedAs() const { return saved_as_; }
  /// Report of the last ended session. None: nothing was cut in it.
  const std::optional<RunReport>& lastResult() const { return last_result_; }

  /// Of the last session that the user ended, until another document opens or the user has read it.
  const std::optional<Debrief>& debrief() const { return debrief_; }
  void endDebrief() { debrief_.reset(); }

  // ---- For other parts

  using Load = std::function<Expected<Opened>(const Progress&)>;
  /// Loads a document in a job and shows it in place of the open one, which is written first.
  void openBy(const std::string& title, Load load);
  /// Continues a branch in place of the open or replayed document.
  void openBranch(const Branch& branch);
  OpeningOptions openingOptions() const;
  /// Calls `next` once no session is open: at once, or after the job that writes it.
  void afterClose(std::function<void()> next);

  struct Reopening {
    std::filesystem::path tool{};                          ///< taken in hand; empty: keeps the tool in hand
    std::vector<CaseBeside> further{};                     ///< neighbours to add
    std::vector<std::filesystem::path> further_sources{};  ///< their files: never written to
    std::optional<Branch> branch{};                        ///< continued in place of the session
    std::string without{};  ///< id of the case of a neighbour to take away from an uncut document; empty: none
  };
  /// Ends the session and continues the open document in another one. Without an open document or beside another job:
  /// no effect but a notice.
  void reopen(Reopening wanted);
  /// As close(), in this thread. The result is lost.
  void endNow();

 private:
  struct Kept;  // state that a reopened document keeps
  void openBy(const std::string& title, Load load, std::shared_ptr<const Kept> kept);
  void openBranch(const Branch& branch, std::shared_ptr<const Kept> kept);
  void show(Opened& loaded, const Kept* kept);
  void restore(const Kept& kept);
  enum class Tells { kAll, kFaults };
  void endRun(bool keeps_ahead, Tells tells);
  void takeEnded(Expected<EndedSession> ended, const std::filesystem::path& folder, Tells tells);
  void tellEnd(const EndedSession& ended, const std::filesystem::path& folder);

  Workbench& bench_;
  bool has_written_ = false, has_failed_ = false;  // at the last end of a session
  std::optional<RunReport> last_result_;
  std::optional<Debrief> debrief_;
  std::filesystem::path saved_as_;
};

}  // namespace kerf
