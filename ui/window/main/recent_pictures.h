// Pictures of recent files and sessions, for the cards of the first screen: once after opening, and again when leaving.
#pragma once

#include <filesystem>
#include <memory>

#include "geometry/base/types.h"
#include "ui/app/base/job.h"
#include "ui/app/document/document.h"
#include "ui/app/view/camera.h"
#include "ui/app/workbench/workbench.h"
#include "ui/window/draw/live_view.h"

namespace kerf {

/// The picture of the open document. Window thread only.
class RecentPicture {
 public:
  /// A picture of this document is due.
  void opened(const Document& document);
  /// The object has grown or moved.
  void updateBox(const Document& document) { box_ = document.scene().bounds(); }
  bool isDue() const { return is_due_; }
  /// Draws it from the camera's side, and writes it in the background. A missing picture is no failure.
  void take(LiveView& view, Workbench& bench, const Camera& camera);
  /// No document is open.
  void forget() { box_ = {}; }

 private:
  bool is_due_ = false;
  std::filesystem::path of_, session_;  // the document, its session folder (empty: a replay), and its box
  Box3 box_;
  std::unique_ptr<Job<void>> writing_;
};

}  // namespace kerf
