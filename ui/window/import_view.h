// What is imported as a picture: scans as they were read, or the closed solids that will be cut.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/camera.h"
#include "ui/app/import_set.h"
#include "ui/app/job.h"
#include "ui/app/mesh_chunks.h"
#include "ui/window/live_renderer.h"

namespace kerf {

/// Needs its OpenGL context current in every call, as LiveRenderer, which it owns one of.
class ImportView {
 public:
  static Expected<std::unique_ptr<ImportView>> create();

  /// Once a frame. What is shown is cut into chunks by a job and handed to the graphics card over several frames; until
  /// all of it is there the picture stays as it was.   @param picture  none: nothing is imported.
  void update(const std::optional<ImportPicture>& picture);
  /// True once after other files, or the same in another unit, are there.
  bool takeFitWanted();
  bool isEmpty() const { return shown_ == kNone; }

  /// The background goes with the panels.
  void setBackground(const Vec3f& middle, const Vec3f& edge) { renderer_->setBackground(middle, edge); }

  Expected<void> draw(const Camera& camera, int width, int height, bool is_still);

 private:
  using Chunks = std::vector<ColouredChunk>;
  explicit ImportView(std::unique_ptr<LiveRenderer> renderer) : renderer_(std::move(renderer)) {}
  void start(const ImportPicture& picture);
  void handOver();

  static constexpr std::size_t kNone = 2;
  std::unique_ptr<LiveRenderer> renderer_;
  std::unique_ptr<Job<Chunks>> job_;
  std::vector<std::unique_ptr<Job<Chunks>>> ending_;  // of scans that were put away
  Chunks waiting_;
  std::size_t next_ = 0;                     // of waiting_
  std::size_t shown_ = kNone;                // object 0 or 1
  std::vector<ImportPicture::Part> wanted_;  // what job_ works on, that waits, or that is shown
  std::string of_, fitted_;                  // ImportPicture::of
  bool is_fit_wanted_ = false;
};

}  // namespace kerf
