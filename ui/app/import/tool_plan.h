// A mesh as a future tool of the rack: its tip, its axis, its cutting length. Writes the tool's files.
//
// The model of a part of the import panel, without OpenGL. Values missing in the mesh are guessed and shown as guesses.
// A cutting end is thin, so the way with the thinnest end comes first.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"
#include "geometry/tool/tool_ways.h"
#include "ui/app/import/import_plan.h"

namespace kerf {

class ToolPlan {
 public:
  /// @param mesh  in the unit of its file.
  ToolPlan(std::filesystem::path file, std::shared_ptr<const Mesh> mesh, double scale_to_mm);

  /// Sets another unit, which changes all lengths. A chosen way stays.
  void setScale(double scale_to_mm);
  double scale() const { return scale_; }
  std::span<const ToolWay> ways() const { return ways_; }
  const ToolWay& way() const { return ways_[way_]; }
  /// @param name  of a way, or "auto".   Error kBadValue.
  Expected<void> setWay(const std::string& name);
  /// mm above the tip: cuts below this height, collides above.
  double cutBelow() const { return cut_below_mm_ > 0 ? cut_below_mm_ : way().cut_below_mm; }
  static constexpr double kLeastCut = 0.1, kMostCut = 50;
  /// Error kBadValue: out of kLeastCut to kMostCut.
  Expected<void> setCutBelow(double mm);
  /// The user has not chosen the way, and another end is hardly wider.
  bool isDoubtful() const;
  /// The assumed tip, and reasons for doubt.
  std::vector<Finding> findings() const;
  /// Id of the tool: the file's name in lower-case letters, digits and hyphens.
  std::string id() const;

 private:
  std::filesystem::path file_;
  std::shared_ptr<const Mesh> mesh_;
  double scale_ = 1;
  std::vector<ToolWay> ways_;
  std::size_t way_ = 0;
  bool is_chosen_ = false;
  double cut_below_mm_ = 0;  // 0: the way's value
};

/// Copied data for the job that writes a tool.
struct MeshToolOrder {
  std::filesystem::path file;  ///< source, for a comment
  std::shared_ptr<const Mesh> mesh;
  double scale_to_mm = 1;
  std::string unit;
  ClosingChoice closing;  ///< for a mesh that is no solid yet
  ToolWay way;
  double cut_below_mm = 4;
  std::string id;                      ///< requested
  std::vector<std::string> ids_taken;  ///< by tools of the rack, in any folder
};

/// Writes ID.toml, as `kerf tool new --shape mesh` does, and ID.ply beside it, in mm. Closes an open mesh first. If the
/// id is taken in the folder, in defaultToolFolders() or in the rack: ID-2, ID-3. Writes both files or none.
/// @param folder  made if missing.   @return  the TOML, which readTool() accepts.
/// Errors: those of closing and of readTool(); kWriteFailed; kCancelled.   @cost  that of closing.
Expected<std::filesystem::path> writeMeshTool(const MeshToolOrder& order, const std::filesystem::path& folder,
                                              const Progress& progress = {});

}  // namespace kerf
