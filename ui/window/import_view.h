// The scan of an import plan as a picture: as it was read, or the closed solid that will be cut.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/camera.h"
#include "ui/app/import_plan.h"
#include "ui/app/job.h"
#include "ui/window/live_renderer.h"
#include "ui/window/mesh_chunks.h"

namespace kerf {

/// Needs its OpenGL context current in every call, as LiveRenderer, which it owns one of.
class ImportView {
 public:
  static Expected<std::unique_ptr<ImportView>> create();

  /// Once a frame. What is shown is cut into chunks by a job and handed to the graphics card over several frames; until
  /// all of it is there the picture stays as it was.   @param plan  null: nothing is imported.
  void update(const ImportPlan* plan, bool shows_solid);
  /// True once after another scan, or the same in another unit, is there.
  bool takeFitWanted();
  bool isEmpty() const { return shown_ == kNone; }

  /// The background goes with the panels.
  void setBackground(const Vec3f& middle, const Vec3f& edge) { renderer_->setBackground(middle, edge); }

  Expected<void> draw(const Camera& camera, int width, int height, bool is_still);

 private:
  using Chunks = std::vector<ColouredChunk>;
  explicit ImportView(std::unique_ptr<LiveRenderer> renderer) : renderer_(std::move(renderer)) {}
  void start(const ImportPlan& plan, bool shows_solid);
  void handOver();

  static constexpr std::size_t kNone = 2;
  std::unique_ptr<LiveRenderer> renderer_;
  std::unique_ptr<Job<Chunks>> job_;
  std::vector<std::unique_ptr<Job<Chunks>>> ending_;  // of scans that were put away
  Chunks waiting_;
  std::size_t next_ = 0;       // of waiting_
  std::size_t shown_ = kNone;  // object 0 or 1
  const ImportPlan* plan_ = nullptr;
  const Mesh* wanted_ = nullptr;  // the mesh that job_ works on, that waits, or that is shown
  double wanted_scale_ = 0;
  double fitted_scale_ = 0;
  bool is_fit_wanted_ = false;
};

}  // namespace kerf
