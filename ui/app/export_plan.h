// An export before it is written: what of the object, in which format, where to, and what a check says of it. The state
// of the window's export panel; scripts reach it by the commands export.*.
//
// What is checked is kept, so that write() writes those very meshes; if something was cut since, they are made and
// checked anew, and what is then not ready is not written before somebody has read so. Owned by the Workbench, and on
// its thread; the work is a job.
#pragma once

#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/cut_stamp.h"
#include "ui/app/exporting.h"
#include "ui/app/show_in_folder.h"

namespace kerf {

class Workbench;
struct MeshFormatRow;

/// Something of what is open that can be exported.
struct ExportOffer {
  std::string label;  ///< "All pieces in one file"
  ExportChoice choice;
};

/// A line of what a check says.
struct ExportFinding {
  bool is_warning = false;
  std::string text;
};

class ExportPlan {
 public:
  explicit ExportPlan(Workbench& bench) : bench_(bench) {}

  bool isShown() const { return is_shown_; }
  /// Suggests a file, beside the scan if that can be, and begins the check.   @param folder  where else; may be empty.
  void show(const std::filesystem::path& folder);
  void hide();
  /// Once a frame, by the workbench.
  void update();

  // ---- What is decided

  /// All that can be chosen now: at least one when something is open.
  std::vector<ExportOffer> offers() const;
  const ExportChoice& choice() const { return choice_; }
  /// Another choice is checked anew.
  void choose(const ExportChoice& choice);
  /// Formats that are written: rows of the table of mesh formats.
  static std::vector<const MeshFormatRow*> formats();
  /// By the file's ending. Null: the ending is of none that is written.
  const MeshFormatRow* format() const;
  /// The name gets the usual ending of it.   Error kBadValue: none of that name is written.
  Expected<void> setFormat(const std::string& name);
  const std::filesystem::path& file() const { return file_; }
  /// A name without an ending keeps that of now; a relative one is in the working folder.   Error kBadValue: no name,
  /// or an ending that is not written.
  Expected<void> setFile(const std::filesystem::path& file);
  /// While it is typed: whatever it is, in the folder of now.
  void setName(const std::string& name);
  /// Files that would be replaced.
  const std::vector<std::filesystem::path>& replaced() const { return replaced_; }

  // ---- What the check says

  enum class Stage {
    kUnchecked,  ///< nobody has, or it was cancelled
    kChecking,
    kRefused,   ///< it can not be exported: error()
    kReady,     ///< to print
    kDoubtful,  ///< it can be written, but is not ready to print
    kWriting,
    kWritten  ///< and nothing was decided otherwise since
  };
  Stage stage() const;
  /// Plain sentences with numbers: those of `kerf check`, for each file. Empty before a check.
  std::vector<ExportFinding> findings() const;
  /// Something was cut or moved since.
  bool isOutdated() const;
  /// Why it was refused, or not written; empty: it was not.
  const std::string& error() const { return error_; }
  /// Makes the meshes and checks them. A job.
  void check();

  // ---- Writing

  struct Permission {
    bool may_replace = false;      ///< files that are there
    bool may_be_doubtful = false;  ///< what is not ready to print
  };
  /// A job; during the check it follows it, if that says it is ready. What would replace a file, or is not ready, is
  /// written when it is asked for a second time, or with that permission: asksToReplace(). If more files would be
  /// replaced than were told, because there are more pieces now, it asks once more.
  void write(Permission permission);
  void write() { write({}); }
  /// write() was asked for, and would replace files: once more, and it does.
  bool asksToReplace() const { return asks_to_replace_; }
  /// What was written last. None: nothing yet, since it was shown.
  const std::optional<WrittenExport>& written() const { return written_; }
  /// It is written, and nothing was decided otherwise or cut since: there is nothing more to do.
  bool isDone() const { return stage() == Stage::kWritten && !isOutdated(); }
  /// Shows what was written in the file manager.   Error kEmpty: nothing was; those of ShowInFolder::begin().
  Expected<void> showInFolder();
  /// Its own work is under way: a job, or the file manager is asked.
  bool isBusy() const { return work_ != Work::kNone || showing_.isUnderWay(); }

 private:
  enum class Work { kNone, kCheck, kWrite };
  struct Outcome {
    ExportChoice choice;
    std::filesystem::path file;
    std::shared_ptr<const PreparedExport> prepared;
    std::optional<CutStamp> stamp;  // of `prepared`, where that was made before; else it is the one handed over
    std::optional<WrittenExport> written{};
    std::optional<std::filesystem::path>
        untold{};  // a file that would be replaced and was not told: nothing is written
  };
  std::filesystem::path suggestedFolder(const std::filesystem::path& otherwise) const;
  void suggestFile(const std::filesystem::path& folder);
  void lookForReplaced();
  bool isCurrent() const;
  void forgetCheck();
  void start(Work work, Permission permission);
  void take(Expected<Outcome> outcome, bool is_new, bool was_written);
  void askToReplace(const std::filesystem::path& untold);

  Workbench& bench_;
  bool is_shown_ = false, wants_check_ = false, is_named_ = false, asks_to_replace_ = false;
  std::optional<Permission> wants_write_;
  std::uint64_t generation_ = 0;  // of the workbench, when it was shown
  std::filesystem::path file_, named_for_;
  ExportChoice choice_;
  std::vector<std::filesystem::path> replaced_;
  Work work_ = Work::kNone;
  std::shared_ptr<const PreparedExport> prepared_;  // of choice_
  std::optional<CutStamp> stamp_;                   // of prepared_
  std::string error_;
  std::optional<WrittenExport> written_;
  ShowInFolder showing_;
};

/// For the job of an export: the scene, when it is handed over.   Error kCancelled.
Expected<SceneCopy> waitForScene(std::future<SceneView>& given, const Progress& progress);

/// As one JSON object, for scripts.
std::string exportState(const ExportPlan& plan);

}  // namespace kerf
