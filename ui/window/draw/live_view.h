// The picture of a workbench: surface, tool in hand, hovering ghost. For window and pictures.
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
#include "ui/app/tool/stroke.h"
#include "ui/app/view/camera.h"
#include "ui/app/view/live_scene.h"
#include "ui/app/view/live_surface.h"
#include "ui/app/workbench/workbench.h"
#include "ui/window/draw/live_renderer.h"
#include "ui/window/draw/saw_view.h"
#include "ui/window/draw/still_picture.h"
#include "ui/window/gl/image.h"

namespace kerf {

/// Like LiveRenderer: its context is current in every call.
class LiveView {
 public:
  static Expected<std::unique_ptr<LiveView>> create();

  /// Runs Workbench::update() and uploads the changes. Once a frame.
  void update(Workbench& bench);
  /// `call` runs before the current surface is dropped, for a last picture of it.
  void setBeforeClear(std::function<void()> call) { before_clear_ = std::move(call); }
  /// Place of the hovering tool; none: no tool.
  void hover(const std::optional<ToolOverSurface>& at) { hover_ = at; }
  /// True once after a new document's surface is there: time to fit the view.
  bool takeFitWanted();
  bool isFitWanted() const { return is_fit_wanted_; }

  /// The panels set the background.
  void setBackground(const Vec3f& middle, const Vec3f& edge) { renderer_->setBackground(middle, edge); }

  /// An opened document is uploaded over several frames; picture() shows all of it.
  bool isUploading() const { return renderer_->counts().waiting_pages > 0; }

  /// Smoothness of edges: moving pictures are drawn fast.
  enum class Edges {
    kFast,
    kSmooth,  ///< in this frame
    kByAndBy  ///< over several frames while nothing changes: StillPicture
  };
  Expected<void> draw(const Workbench& bench, const Camera& camera, int width, int height, Edges edges);
  /// draw() would show the same picture again, as smooth as the last one: it can be left out.
  bool isDrawn(const Workbench& bench, const Camera& camera, int width, int height, Edges edges);
  Expected<Image> picture(const Workbench& bench, const Camera& camera, int width, int height);

 private:
  explicit LiveView(std::unique_ptr<LiveRenderer> renderer) : renderer_(std::move(renderer)) {}
  LiveFrame frameOf(const Workbench& bench, const Camera& camera);
  void showTool(const Workbench& bench);
  void setChunk(const Workbench& bench, std::size_t object, const MeshChunk& chunk);
  void takeTissues(Workbench& bench);
  void takeAsLoaded(const Workbench& bench);
  bool isAsLoadedDrawn(const Workbench& bench) const;
  void lookForPieces(const Workbench& bench, const std::vector<ObjectChunks>& changed);
  void recolour(const Workbench& bench);
  void recolour(const Workbench& bench, const SceneObject& object);
  void tintPieces(const Workbench& bench);
  void showContacts(const Workbench& bench);
  void placeObjects(const Workbench& bench);
  void place(std::size_t object, const Rigid3& pose, bool is_visible, bool is_ghost);
  void showSection(const Workbench& bench);

  std::unique_ptr<LiveRenderer> renderer_;
  std::uint64_t generation_ = 0;
  std::vector<std::size_t> placed_;                          // renderer's numbers in the last picture
  std::map<std::size_t, LiveSurface> parts_;                 // of tissues, by their number
  bool has_as_loaded_ = false, is_as_loaded_whole_ = false;  // in the renderer; uploaded
  std::uint64_t colours_version_ = 0;
  std::map<std::uint32_t, std::string> tints_;  // by object, as on the graphics card
  std::map<std::uint32_t, Rigid3> posed_;       // poses that their contacts are of
  std::map<std::size_t, Plane> sections_;       // by number, in their frames, as they are on the graphics card
  std::optional<std::size_t> tool_;
  std::optional<ToolOverSurface> hover_;
  SawView saw_;
  StillPicture still_;
  std::optional<PictureContent> drawn_;  // by the last draw(); none: not yet final
  std::set<std::uint32_t> known_;        // objects that have a surface in the renderer
  bool is_fit_wanted_ = false;
  bool is_whole_wanted_ = false;  // the next frame uploads all: its content replaces other content
  std::function<void()> before_clear_;
};

}  // namespace kerf
