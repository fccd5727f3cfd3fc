// A picture whose edges get smooth from frame to frame while nothing moves. For a processor without a graphics card:
// supersampling at once would take 150 ms and delay hands that start again.
#pragma once

#include <epoxy/gl.h>

#include <cstdint>
#include <optional>

#include "ui/window/draw/live_renderer.h"
#include "ui/window/gl/gl_program.h"

namespace kerf {

/// The content of a picture: two equal ones look the same, but for the smoothness of edges.
struct PictureContent {
  std::uint64_t version = 0;  ///< LiveRenderer::version()
  Camera camera{};
  int width = 0, height = 0;
  LiveFrame frame{};

  bool isSame(const PictureContent& other) const;
};

/// Draws the same scene again and again, each time offset by a part of a pixel, and shows the mean. After kSamples
/// frames it shows the stored mean. Like LiveRenderer: its context is current in every call, the destructor included.
class StillPicture {
 public:
  static constexpr int kSamples = 4;

  StillPicture() = default;
  ~StillPicture();
  StillPicture(const StillPicture&) = delete;
  StillPicture& operator=(const StillPicture&) = delete;

  /// Like LiveRenderer::draw(). A change since the last call restarts it. Planned cuts are drawn without smoothing:
  /// they move with the hand.   @cost  two copies more than a frame, 15 ms at 1280 x 720; one copy once it is smooth.
  Expected<void> draw(LiveRenderer& renderer, const Camera& camera, int width, int height, const LiveFrame& frame);
  /// The next call restarts.
  void forget() { samples_ = 0; }
  /// Number of kSamples in the shown picture; 0: drawn without smoothing.
  int samples() const { return samples_; }
  /// Further calls with the same content would show the same picture.
  bool isFinal() const { return samples_ == kSamples || !subject_; }

 private:
  Expected<void> prepare(int width, int height);
  void add(int sample);
  void show(GLuint target, int width, int height);

  std::optional<PictureContent> subject_;
  int samples_ = 0;
  int width_ = 0, height_ = 0;
  internal::GlProgram square_, root_;
  GLuint empty_array_ = 0;
  GLuint drawn_target_ = 0, drawn_color_ = 0, drawn_depth_ = 0;  // one sample
  GLuint mean_target_ = 0, mean_color_ = 0;                      // of the squares, since sRGB does not add up
};

}  // namespace kerf
