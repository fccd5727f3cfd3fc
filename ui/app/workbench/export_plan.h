// A planned export: selection, format, file and check result. Model of the window's export panel; scripts use it
// through the commands export.*.
//
// The plan keeps the checked meshes and write() writes these. After further cutting it makes and checks new meshes; if
// they are not ready to print, it writes them only after the user has seen the warning. Owned by the Workbench, on its
// thread; the work is a job.
#pragma once

#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/base/show_in_folder.h"
#include "ui/app/document/part.h"
#include "ui/app/session/exporting.h"
#include "ui/app/tool/cut_stamp.h"

namespace kerf {

class Workbench;
struct MeshFormatRow;

/// A part of the open object that can be exported.
struct ExportOffer {
  std::string label;  ///< "All pieces in one file"
  ExportChoice choice;
};

/// A line of a check result.
struct ExportFinding {
  bool is_warning = false;
  std::string text;
};

/// Window thread only.
class ExportPlan final : public Part {
 public:
  explicit ExportPlan(Workbench& bench) : bench_(bench) {}

  bool isShown() const { return is_shown_; }
  /// Suggests a file, if possible beside the scan, and starts the check.   @param folder  fallback; may be empty.
  void show(const std::filesystem::path& folder);
  void hide();
  void update() override;

  // ---- Choices

  /// All current choices: at least one if an object is open.
  std::vector<ExportOffer> offers() const;
  const ExportChoice& choice() const { return choice_; }
  /// A new choice starts a new check. Until the first, pieces that touch along a cut without kerf get a file each.
  void choose(const ExportChoice& choice);
  /// Writable formats: rows of the table of mesh formats.
  static std::vector<const MeshFormatRow*> formats();
  /// Format of the file's ending. Null if Kerf does not write it.
  const MeshFormatRow* format() const;
  /// Gives the file the format's usual ending.   Error kBadValue: no writable format has that name.
  Expected<void> setFormat(const std::string& name);
  const std::filesystem::path& file() const { return file_; }
  /// A name without an ending keeps the current one; a relative path starts in the working folder.   Error kBadValue:
  /// no name, or an ending that Kerf does not write.
  Expected<void> setFile(const std::filesystem::path& file);
  /// Sets the name, or a whole path, during typing. Its folder and ending, if missing, are
  /// those of the file before.   @param before  file() when typing began.
  void setName(const std::string& name, const std::filesystem::path& before);
  /// Existing files that write() would replace.
  const std::vector<std::filesystem::path>& replaced() const { return replaced_; }

  // ---- Check result

  enum class Stage {
    kUnchecked,  ///< not started, or cancelled
    kChecking,
    kRefused,   ///< cannot be exported: error()
    kReady,     ///< ready to print
    kDoubtful,  ///< can be written, but is not ready to print
    kWriting,
    kWritten  ///< and no choice changed since
  };
  Stage stage() const;
  /// Sentences of `kerf check` for each file. Empty before a check.
  std::vector<ExportFinding> findings() const;
  /// The object was cut or moved since the check.
  bool isOutdated() const;
  /// Why the check or the write failed; empty: no failure.
  const std::string& error() const { return error_; }
  /// Makes the meshes and checks them. A job.
  void check();

  // ---- Writing

  struct Permission {
    bool may_replace = false;      ///< existing files
    bool may_be_doubtful = false;  ///< meshes that are not ready to print
  };
  /// A job. During a check it waits and then runs if the meshes are ready. Replacing files (asksToReplace()) or writing
  /// unready meshes needs a second call or the permission. If new pieces would replace further files, it prompts again.
  void write(Permission permission);
  void write() { write({}); }
  /// write() would replace files and waits for a second call.
  bool asksToReplace() const { return asks_to_replace_; }
  /// The last written export. None: nothing written since show().
  const std::optional<WrittenExport>& written() const { return written_; }
  /// Written, and no choice or object changed since.
  bool isDone() const { return stage() == Stage::kWritten && !isOutdated(); }
  /// Shows the written files in the file manager.   Error kEmpty: none written; those of ShowInFolder::begin().
  Expected<void> showInFolder();
  /// A job of the plan runs, or the request to the file manager is pending.
  bool isBusy() const { return work_ != Work::kNone || showing_.isUnderWay(); }

 private:
  enum class Work { kNone, kCheck, kWrite };
  struct Outcome {
    ExportChoice choice;
    std::filesystem::path file;
    std::shared_ptr<const PreparedExport> prepared;
    std::optional<CutStamp> stamp;  // of an earlier `prepared`; a new one has the stamp of the handed-over scene
    std::optional<WrittenExport> written{};
    std::optional<std::filesystem::path> untold{};  // an unannounced file that would be replaced: nothing is written
  };
  std::filesystem::path suggestedFolder(const std::filesystem::path& otherwise) const;
  void suggestFile(const std::filesystem::path& folder);
  void lookForReplaced();
  bool isCurrent() const;
  void forgetCheck();
  void start(Work work, Permission permission);
  void take(Expected<Outcome> outcome, bool is_new, bool was_written);
  void splitTouching(const Outcome& outcome, bool was_written);
  void askToReplace(const std::filesystem::path& untold);

  Workbench& bench_;
  bool is_shown_ = false, wants_check_ = false, is_named_ = false, is_chosen_ = false, asks_to_replace_ = false;
  std::optional<Permission> wants_write_;
  std::uint64_t generation_ = 0;  // of the workbench at show()
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

/// State as one JSON object, for scripts.
std::string exportState(const ExportPlan& plan);

}  // namespace kerf
