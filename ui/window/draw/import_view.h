// The picture of an import: scans as read, or the closed solids.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/base/job.h"
#include "ui/app/import/import_set.h"
#include "ui/app/view/camera.h"
#include "ui/app/view/mesh_chunks.h"
#include "ui/window/draw/live_renderer.h"
#include "ui/window/draw/still_picture.h"

namespace kerf {

/// Needs its OpenGL context current in every call, like the LiveRenderer it owns.
class ImportView {
 public:
  static Expected<std::unique_ptr<ImportView>> create();

  /// Once a frame. A job splits the parts into chunks; uploading takes several frames. Until all chunks are there the
  /// old picture stays.   @param picture  none: no import.
  void update(const std::optional<ImportPicture>& picture);
  /// True once after the files or their unit changed.
  bool takeFitWanted();
  bool isEmpty() const { return shown_ == kNone; }

  /// The panels set the background.
  void setBackground(const Vec3f& middle, const Vec3f& edge) { renderer_->setBackground(middle, edge); }

  Expected<void> draw(const Camera& camera, int width, int height, bool is_still);
  /// draw() would show the same picture again: it can be left out.
  bool isDrawn(const Camera& camera, int width, int height, bool is_still) const;

 private:
  using Chunks = std::vector<ColouredChunk>;
  explicit ImportView(std::unique_ptr<LiveRenderer> renderer) : renderer_(std::move(renderer)) {}
  void start(const ImportPicture& picture);
  void handOver();

  static constexpr std::size_t kNone = 2;
  std::unique_ptr<LiveRenderer> renderer_;
  std::unique_ptr<Job<Chunks>> job_;
  std::vector<std::unique_ptr<Job<Chunks>>> ending_;  // of closed scans
  Chunks waiting_;
  std::size_t next_ = 0;                     // index in waiting_
  std::size_t shown_ = kNone;                // object 0 or 1
  std::vector<ImportPicture::Part> wanted_;  // parts in job_, waiting or shown
  std::string of_, fitted_;                  // ImportPicture::of
  bool is_fit_wanted_ = false;
  PictureContent drawn_;  // by the last draw()
  bool is_drawn_still_ = false;
};

}  // namespace kerf
