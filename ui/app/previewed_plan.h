// The solid of an import plan, computed by a job of its own before it is cut.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"
#include "ui/app/job.h"

namespace kerf {

/// What cutting at a voxel size will take. See predict().
struct Prediction {
  double seconds = 0;            ///< until the tool can be held
  double bytes = 0;              ///< of the whole program, at its peak
  double surface_triangles = 0;  ///< of the surface that is drawn
};

/// The solid that will be cut, before it is cut.
struct ClosedPreview {
  std::shared_ptr<const Mesh> solid;  ///< mm; what was added is of another colour than what was scanned
  std::vector<std::string> changes;   ///< sentences
  std::vector<std::string> warnings;  ///< those of them that went beyond what was asked for
  bool is_exact = true;               ///< false: shrink-wrapped, an approximation
  double volume_mm3 = 0, area_mm2 = 0;
  double seconds = 0;                        ///< that closing took
  std::optional<Vec3d> base_direction = {};  ///< unit, out of the model; none: no base was added
  double base_level_mm = 0;                  ///< the base is {x : base_direction . x = base_level_mm}
  std::optional<Plane> occlusal_plane = {};  ///< that the base is parallel to
};

/// A plan with a preview. One thread calls everything.
class PreviewedPlan {
 public:
  virtual ~PreviewedPlan() = default;

  virtual Prediction prediction() const = 0;
  /// Of memory, when the plan was made.
  double freeBytes() const { return free_bytes_; }

  /// Once a frame. Takes what the preview's job has done; starts it a moment after the last choice, unless that takes
  /// long (a wrap, a million triangles): then startPreview() does.   @return true: there is another one, or none any
  /// more.
  bool update();
  void startPreview();
  void cancelPreview();
  virtual bool startsByItself() const = 0;
  /// It is being computed, or will be in a moment.
  bool isPreviewComing() const { return job_ || (is_preview_due_ && startsByItself()); }
  /// Makes way for other work; it begins again when update() is called after that.
  void suspendPreview();
  /// Null: none yet, or the choices have changed since.
  const ClosedPreview* preview() const { return preview_ ? &*preview_ : nullptr; }
  /// Why there is none: preparing would fail in the same way.
  const std::optional<Error>& previewError() const { return preview_error_; }
  /// No thread works for it: destroying it waits for nothing.
  bool isIdle() const { return !job_ || job_->isOver(); }
  const AnyJob* previewJob() const { return job_.get(); }

 protected:
  PreviewedPlan();
  /// After each choice that changes the solid.
  void changed();
  /// Null: there is nothing to show.
  virtual std::unique_ptr<Job<ClosedPreview>> makePreview() const = 0;
  double previewSeconds() const { return preview_s_; }  ///< that the last preview took; 0: none yet

 private:
  std::chrono::steady_clock::time_point changed_at_ = std::chrono::steady_clock::now();
  bool is_preview_due_ = true;
  std::unique_ptr<Job<ClosedPreview>> job_;
  std::optional<ClosedPreview> preview_;
  std::optional<Error> preview_error_;
  double preview_s_ = 0, free_bytes_ = 0;
};

}  // namespace kerf
