// The files that are looked at before they are prepared: one or several, dropped together. Which one is cut, which
// stand beside it, which are left out; and for each what is decided about it.
//
// The model of the import panel, without OpenGL. One thread, the window's, calls everything.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "ui/app/import_plan.h"
#include "ui/app/label_plan.h"
#include "ui/app/opening.h"
#include "ui/app/tool_plan.h"

namespace kerf {

enum class ImportRole {
  kCut,
  kBeside,
  kOut,
  kTool  ///< a scan alone: it becomes a tool of the rack
};

/// What reading a file gave; of a recipe and of a case nothing is read, they are prepared as they say.
struct ImportRead {
  std::filesystem::path file;
  FileKind kind = FileKind::kScan;
  std::optional<ScanFound> scan;      ///< of a scan
  std::optional<LabelsFound> labels;  ///< of a label volume
};
/// Errors: those of readScan() and readLabels(); kUnsupported for a run or a tool.   For a job.
Expected<ImportRead> readToImport(const std::filesystem::path& file, const Progress& progress = {});

struct ImportEntry {
  std::filesystem::path file;
  FileKind kind = FileKind::kScan;
  ImportRole role = ImportRole::kBeside;
  std::unique_ptr<ImportPlan> scan;   ///< null: it is no scan
  std::unique_ptr<LabelPlan> labels;  ///< null: it is no label volume
  std::unique_ptr<ToolPlan> tool;     ///< null: it is no tool
  /// Unit and voxel size that the program was told, which hold for a recipe, too; in the panels nothing is asked about
  /// it.
  PrepareOptions told;
  PreviewedPlan* plan() const;  ///< scan or labels; null: neither
  /// "scan", "labels of a CT", "recipe" or "case".
  std::string what() const;
  /// What was chosen about it, for openToCut(): an untouched unit and voxel size stay open, so that the same case is
  /// found again.
  PrepareOptions decided() const;
};

/// What is drawn while files are imported, as triangles in mm.
struct ImportPicture {
  struct Part {
    std::shared_ptr<const Mesh> mesh;
    double scale_to_mm = 1;
    bool is_open = false;    ///< its inside is seen
    bool is_beside = false;  ///< pale: what is decided is decided about another one
    bool operator==(const Part&) const = default;
  };
  std::vector<Part> parts;
  Box3 box;                   ///< mm, of all
  Vec3d up = Vec3d::UnitZ();  ///< it is looked at from there
  std::string of;             ///< another name: the view is fitted anew
};

class ImportSet {
 public:
  /// The first is cut and is chosen, the others stand beside.   @pre at least one.
  ImportSet(std::vector<ImportRead> read, const PrepareOptions& defaults, const MaterialTable& materials);
  /// More of them, to stand beside. The first of these is chosen.
  void add(std::vector<ImportRead> read);

  const std::vector<ImportEntry>& entries() const { return entries_; }
  bool isSeveral() const { return entries_.size() > 1; }
  /// The one whose choices are shown.
  std::size_t chosen() const { return chosen_; }
  void choose(std::size_t n);
  /// Null: what is chosen is no scan, or no label volume.
  ImportPlan* scan() const { return entries_[chosen_].scan.get(); }
  LabelPlan* labels() const { return entries_[chosen_].labels.get(); }
  /// Null: what is chosen becomes no tool. Its lengths are those of the unit that is chosen.
  ToolPlan* tool() const;
  /// The one that is cut; null: none of them.
  const ImportEntry* cut() const;
  /// One is cut at any time: what was cut before then stands beside. When the one that is cut becomes a tool, the first
  /// of those that stand beside is cut.
  /// @param may_lack_cut  something is open: what stands beside stands beside that, and nothing here need be cut.
  /// Errors: kBadValue for taking the role of the one that is cut; kUnsupported for a tool that is no scan.
  Expected<void> setRole(std::size_t n, ImportRole role, bool may_lack_cut = false);
  /// What is to be written as tools, in the order of entries().
  std::vector<MeshToolOrder> toolOrders() const;
  /// They are written: they are left out from now on.
  void toolsAreMade();

  /// What stands in the way of preparing it: a label volume of which nothing is left, or frames that can not be one.
  std::vector<Finding> findings() const;
  /// Errors: kEmpty: of a label volume that is not left out all labels are; kBadValue: units that are guessed differ.
  Expected<void> requireReady() const;
  /// Of all that is not left out, together.
  Prediction prediction() const;
  double freeBytes() const;

  // ---- Previews

  /// Of the chosen one; null: it has none.
  PreviewedPlan* plan() const { return entries_[chosen_].plan(); }
  const ClosedPreview* preview() const { return plan() ? plan()->preview() : nullptr; }
  /// Once a frame: PreviewedPlan::update() of the chosen one, and of others that are under way.
  void update();
  void suspendPreviews();
  bool isIdle() const;
  ImportPicture picture(bool shows_solid) const;

 private:
  std::vector<ImportEntry> entries_;
  std::size_t chosen_ = 0;
  PrepareOptions defaults_;
  MaterialTable materials_;
};

}  // namespace kerf
