// Files of an import before preparation, one or several: each has a role (cut, beside, out, tool) and its own choices.
//
// The model of the import panel, without OpenGL. Window thread only.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "ui/app/import/import_plan.h"
#include "ui/app/import/label_plan.h"
#include "ui/app/import/opening.h"
#include "ui/app/import/tool_plan.h"

namespace kerf {

enum class ImportRole {
  kCut,
  kBeside,
  kOut,
  kTool  ///< scans only: becomes a tool of the rack
};

/// Content of a file. Recipes and cases are not read here; they define their own preparation.
struct ImportRead {
  std::filesystem::path file;
  FileKind kind = FileKind::kScan;
  std::optional<ScanFound> scan;      ///< set for a scan
  std::optional<LabelsFound> labels;  ///< set for a label volume
};
/// Errors: those of readScan() and readLabels(); kUnsupported for a run or a tool.   For a job.
Expected<ImportRead> readToImport(const std::filesystem::path& file, const Progress& progress = {});

struct ImportEntry {
  std::filesystem::path file;
  FileKind kind = FileKind::kScan;
  ImportRole role = ImportRole::kBeside;
  std::unique_ptr<ImportPlan> scan;   ///< null unless a scan
  std::unique_ptr<LabelPlan> labels;  ///< null unless a label volume
  std::unique_ptr<ToolPlan> tool;     ///< null unless a tool
  /// Unit and voxel size given to the program. They also apply to a recipe, which the panels have no choices for.
  PrepareOptions told;
  PreviewedPlan* plan() const;  ///< scan or labels; null: neither
  /// "scan", "labels of a CT", "recipe" or "case".
  std::string what() const;
  /// Choices for openToCut(). An untouched unit or voxel size stays unset, so that it finds the same case again.
  PrepareOptions decided() const;
};

/// Preview of an import, as triangles in mm.
struct ImportPicture {
  struct Part {
    std::shared_ptr<const Mesh> mesh;
    double scale_to_mm = 1;
    bool is_open = false;    ///< the inside is visible
    bool is_beside = false;  ///< pale: not the chosen file
    bool operator==(const Part&) const = default;
  };
  std::vector<Part> parts;
  Box3 box;                   ///< mm, of all parts
  Vec3d up = Vec3d::UnitZ();  ///< towards the viewer
  std::string of;             ///< identity; a new value fits the view again
};

class ImportSet {
 public:
  /// The first file is cut and chosen, the others stand beside it.   @pre at least one.
  ImportSet(std::vector<ImportRead> read, const PrepareOptions& defaults, const MaterialTable& materials);
  /// Adds files to stand beside, and chooses the first of them.
  void add(std::vector<ImportRead> read);

  const std::vector<ImportEntry>& entries() const { return entries_; }
  bool isSeveral() const { return entries_.size() > 1; }
  /// Index of the file whose choices the panel shows.
  std::size_t chosen() const { return chosen_; }
  void choose(std::size_t n);
  /// Null if the chosen file is not a scan, or not a label volume.
  ImportPlan* scan() const { return entries_[chosen_].scan.get(); }
  LabelPlan* labels() const { return entries_[chosen_].labels.get(); }
  /// Null if the chosen file is not a tool. Its lengths follow the chosen unit.
  ToolPlan* tool() const;
  /// The file to cut; null: none.
  const ImportEntry* cut() const;
  /// Only one file is cut: the previous one then stands beside. If the cut file becomes a tool, the first file beside
  /// takes its role.
  /// @param may_lack_cut  an object is open: files stand beside it, and none need be cut.
  /// Errors: kBadValue for removing the only cut file; kUnsupported for a tool that is not a scan.
  Expected<void> setRole(std::size_t n, ImportRole role, bool may_lack_cut = false);
  /// Tools to write, in the order of entries().
  std::vector<MeshToolOrder> toolOrders() const;
  /// Call after writing the tools: sets their role to kOut.
  void toolsAreMade();

  /// Doubts about the set: differing guessed units, or files too far apart for one frame.
  std::vector<Finding> findings() const;
  /// Errors: kEmpty: a label volume in use has no label with a tissue; kBadValue: guessed units differ.
  Expected<void> requireReady() const;
  /// Sum for the files that are cut or beside.
  Prediction prediction() const;
  double freeBytes() const;

  // ---- Previews

  /// Plan of the chosen file; null: none.
  PreviewedPlan* plan() const { return entries_[chosen_].plan(); }
  const ClosedPreview* preview() const { return plan() ? plan()->preview() : nullptr; }
  /// Call once a frame: PreviewedPlan::update() of the chosen file and of running previews.
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
