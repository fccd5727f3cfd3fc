// The solid of an import plan. A separate job computes it before cutting.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"
#include "ui/app/base/job.h"

namespace kerf {

/// Expected time and memory at a voxel size. See predict().
struct Prediction {
  double seconds = 0;            ///< until the tool is ready
  double bytes = 0;              ///< of the whole program, at its peak
  double surface_triangles = 0;  ///< of the drawn surface
};

/// The solid before it is opened for cutting.
struct ClosedPreview {
  std::shared_ptr<const Mesh> solid;  ///< mm; added surface differs in colour from scanned surface
  std::vector<std::string> changes;   ///< sentences
  std::vector<std::string> warnings;  ///< changes beyond the requested ones
  bool is_exact = true;               ///< false: shrink-wrapped, an approximation
  double volume_mm3 = 0, area_mm2 = 0;
  double seconds = 0;                        ///< time of closing
  std::optional<Vec3d> base_direction = {};  ///< unit, out of the model; none: no base
  double base_level_mm = 0;                  ///< the base is {x : base_direction . x = base_level_mm}
  std::optional<Plane> occlusal_plane = {};  ///< parallel to the base
};

/// A plan with a preview. One thread makes all calls.
class PreviewedPlan {
 public:
  virtual ~PreviewedPlan() = default;

  virtual Prediction prediction() const = 0;
  /// Free memory when the plan was made.
  double freeBytes() const { return free_bytes_; }

  /// Once a frame. Takes results of the preview's job. Starts the job a moment after the last choice; if it takes long
  /// (a wrap, a million triangles), only startPreview() starts it.   @return true: the preview changed or is gone.
  bool update();
  void startPreview();
  void cancelPreview();
  virtual bool startsByItself() const = 0;
  /// It is being computed, or starts in a moment.
  bool isPreviewComing() const { return job_ || (is_preview_due_ && startsByItself()); }
  /// Stops the preview for other work. The next update() starts it again.
  void suspendPreview();
  /// Null: none yet, or the choices have changed since.
  const ClosedPreview* preview() const { return preview_ ? &*preview_ : nullptr; }
  /// The reason for a missing preview: preparing would fail in the same way.
  const std::optional<Error>& previewError() const { return preview_error_; }
  /// No thread works for it: its destructor does not wait.
  bool isIdle() const { return !job_ || job_->isOver(); }
  const AnyJob* previewJob() const { return job_.get(); }

 protected:
  PreviewedPlan();
  /// To call after each choice that changes the solid.
  void changed();
  /// Null: nothing to show.
  virtual std::unique_ptr<Job<ClosedPreview>> makePreview() const = 0;
  double previewSeconds() const { return preview_s_; }  ///< time of the last preview; 0: none yet

 private:
  std::chrono::steady_clock::time_point changed_at_ = std::chrono::steady_clock::now();
  bool is_preview_due_ = true;
  std::unique_ptr<Job<ClosedPreview>> job_;
  std::optional<ClosedPreview> preview_;
  std::optional<Error> preview_error_;
  double preview_s_ = 0, free_bytes_ = 0;
};

}  // namespace kerf
