// A mesh that is to be a tool of the rack: which end is its tip, which way it goes in, how far it cuts. And the files
// that make it one.
//
// The model of a part of the import panel, without OpenGL. What a mesh does not say is guessed and shown as a guess: a
// cutting end is thin, and so the way whose end is thinnest comes first.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"
#include "ui/app/import_plan.h"

namespace kerf {

/// How a mesh may be held.
struct ToolWay {
  /// "+z"; "length", "-length": along the longest way through it, or against that; "thin-end".
  std::string name;
  Vec3d axis = Vec3d::UnitZ();  ///< from the tip to the shank, unit
  Vec3d tip = Vec3d::Zero();    ///< mm, in the middle of what is near its end
  double tip_width_mm = 0;      ///< across, of what is within kTipLength of the end
  double cut_below_mm = 4;      ///< above the tip: as far as it is hardly wider than near its end, 4 mm at most
  static constexpr double kTipLength = 2;  ///< mm
};

/// Six along the axes of the file, two along its length, and "thin-end", from the thinnest end that sticks out to any
/// side, if one does; the thinnest tip first.
/// @param mesh_mm  at least one triangle; vertices that no triangle has do not count.
std::vector<ToolWay> toolWays(const Mesh& mesh_mm);

class ToolPlan {
 public:
  /// @param mesh  in the unit of its file.
  ToolPlan(std::filesystem::path file, std::shared_ptr<const Mesh> mesh, double scale_to_mm);

  /// Another unit: all lengths are others. The way that was chosen stays.
  void setScale(double scale_to_mm);
  double scale() const { return scale_; }
  std::span<const ToolWay> ways() const { return ways_; }
  const ToolWay& way() const { return ways_[way_]; }
  /// @param name  of a way, or "auto".   Error kBadValue.
  Expected<void> setWay(const std::string& name);
  /// mm above the tip: up to there it cuts, above it collides.
  double cutBelow() const { return cut_below_mm_ > 0 ? cut_below_mm_ : way().cut_below_mm; }
  static constexpr double kLeastCut = 0.1, kMostCut = 50;
  /// Error kBadValue: out of kLeastCut to kMostCut.
  Expected<void> setCutBelow(double mm);
  /// Nobody has chosen the way, and another end is hardly wider.
  bool isDoubtful() const;
  /// What is taken for the tip, and why that may be wrong.
  std::vector<Finding> findings() const;
  /// Of the tool: the file's name in lower-case letters, digits and hyphens.
  std::string id() const;

 private:
  std::filesystem::path file_;
  std::shared_ptr<const Mesh> mesh_;
  double scale_ = 1;
  std::vector<ToolWay> ways_;
  std::size_t way_ = 0;
  bool is_chosen_ = false;
  double cut_below_mm_ = 0;  // 0: that of the way
};

/// What a job needs to write a tool; copies.
struct MeshToolOrder {
  std::filesystem::path file;  ///< what it comes from, for a comment
  std::shared_ptr<const Mesh> mesh;
  double scale_to_mm = 1;
  std::string unit;
  ClosingChoice closing;  ///< what closes a mesh that is no solid yet
  ToolWay way;
  double cut_below_mm = 4;
  std::string id;                      ///< that is wished for
  std::vector<std::string> ids_taken;  ///< of tools of the rack, wherever their files are
};

/// Writes ID.toml, as `kerf tool new --shape mesh` does, and ID.ply beside it, in mm; a mesh that is no closed solid is
/// closed first. If there is one of that id, in the folder, in defaultToolFolders() or in the rack: ID-2, ID-3. Both
/// files are there at the end, or none.
/// @param folder  made if need be.   @return  the TOML, which readTool() accepts.
/// Errors: those of closing and of readTool(); kWriteFailed; kCancelled.   @cost  that of closing.
Expected<std::filesystem::path> writeMeshTool(const MeshToolOrder& order, const std::filesystem::path& folder,
                                              const Progress& progress = {});

}  // namespace kerf
