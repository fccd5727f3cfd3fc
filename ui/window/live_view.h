// What the window shows of a workbench: its surface, the tool in hand, the ghost that hovers. For window and pictures.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "geometry/base/error.h"
#include "ui/app/camera.h"
#include "ui/app/workbench.h"
#include "ui/window/image.h"
#include "ui/window/live_renderer.h"
#include "ui/window/saw_view.h"
#include "ui/window/still_picture.h"

namespace kerf {

/// As LiveRenderer: its context is current in every call.
class LiveView {
 public:
  static Expected<std::unique_ptr<LiveView>> create();

  /// Workbench::update(), and what came of it to the graphics card. Once a frame.
  void update(Workbench& bench);
  /// Called before what is shown is given up, for a last picture of it.
  void setBeforeClear(std::function<void()> call) { before_clear_ = std::move(call); }
  /// Where the tool hovers; none: nowhere.
  void hover(const std::optional<ToolOverSurface>& at) { hover_ = at; }
  /// True once after something else was opened and its surface is there: time to fit the view.
  bool takeFitWanted();
  bool isFitWanted() const { return is_fit_wanted_; }

  /// The background goes with the panels.
  void setBackground(const Vec3f& middle, const Vec3f& edge) { renderer_->setBackground(middle, edge); }

  /// What was opened comes into the picture over several frames; picture() shows all of it.
  bool isUploading() const { return renderer_->counts().waiting_pages > 0; }

  /// How smooth the edges are: what moves is drawn fast.
  enum class Edges {
    kFast,
    kSmooth,  ///< in this frame
    kByAndBy  ///< from frame to frame, as long as nothing changes: StillPicture
  };
  Expected<void> draw(const Workbench& bench, const Camera& camera, int width, int height, Edges edges);
  Expected<Image> picture(const Workbench& bench, const Camera& camera, int width, int height);

 private:
  explicit LiveView(std::unique_ptr<LiveRenderer> renderer) : renderer_(std::move(renderer)) {}
  LiveFrame frameOf(const Workbench& bench, const Camera& camera);
  void showTool(const Workbench& bench);
  void setChunk(const Workbench& bench, std::size_t object, const MeshChunk& chunk);
  void takeTissues(Workbench& bench);
  void lookForPieces(const Workbench& bench, const std::vector<ObjectChunks>& changed);
  void recolour(const Workbench& bench);
  void recolour(const Workbench& bench, const SceneObject& object);
  void tintPieces(const Workbench& bench);
  void placeObjects(const Workbench& bench);
  void place(std::size_t object, const Rigid3& pose, bool is_visible, bool is_ghost);
  void showSection(const Workbench& bench);

  std::unique_ptr<LiveRenderer> renderer_;
  std::uint64_t generation_ = 0;
  std::vector<std::size_t> placed_;           // numbers of the renderer that were in the last picture
  std::map<std::size_t, LiveSurface> parts_;  // of tissues, by their number
  std::uint64_t colours_version_ = 0;
  std::map<std::uint32_t, std::string> tints_;  // of objects, as on the graphics card
  std::map<std::size_t, Plane> sections_;       // by number, in their frames, as they are on the graphics card
  std::optional<std::size_t> tool_;
  std::optional<ToolOverSurface> hover_;
  SawView saw_;
  StillPicture still_;
  std::set<std::uint32_t> known_;  // objects that have a surface in the renderer
  bool is_fit_wanted_ = false;
  bool is_whole_wanted_ = false;  // the next frame uploads all: what it shows takes the place of something
  std::function<void()> before_clear_;
};

}  // namespace kerf
