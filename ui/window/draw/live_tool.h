// The tool in a live picture: its mesh, its tint and shadow on tissue, the line along its axis. OpenGL 3.3 core.
#pragma once

#include <epoxy/gl.h>

#include "geometry/base/error.h"
#include "ui/app/tool/tool_look.h"
#include "ui/window/draw/live_parts.h"
#include "ui/window/gl/gl_program.h"

namespace kerf {

struct LiveFrame;

namespace internal {

/// How the tool changes the look of a place.
enum class Reach { kNone, kShadow, kTip };

/// Reach of the tool, in an object's frame.
struct ToolReach {
  Rigid3 T_approach_object;
  Box3 around_tip, in_shadow;  ///< approach frame; empty: none

  Reach of(const Box3& box) const {
    const Box3 there = box.transformed(T_approach_object);
    const auto touches = [&](const Box3& other) {
      return (there.min.array() <= other.max.array()).all() && (there.max.array() >= other.min.array()).all();
    };
    return touches(around_tip) ? Reach::kTip : touches(in_shadow) ? Reach::kShadow : Reach::kNone;
  }
};

/// Needs its OpenGL context current in every call, the destructor included.
class LiveTool {
 public:
  LiveTool();
  ~LiveTool();
  LiveTool(const LiveTool&) = delete;
  LiveTool& operator=(const LiveTool&) = delete;

  Expected<void> build();
  /// A few ms. An empty mesh: no tool.
  void set(const ToolLook& look);
  bool isEmpty() const { return corners_ == 0; }
  const Box3& box() const { return box_; }  ///< tool frame, mm

  /// Where the tool tints and darkens an object at that pose.
  ToolReach reachOf(const LiveFrame& frame, const Rigid3& T_world_tool, const Rigid3& T_world_object) const;
  /// From an object's frame to the approach frame, in which the tool goes in along -z.
  Rigid3 toApproach(const Rigid3& T_world_tool, const Rigid3& T_world_object) const;
  /// Texture unit 0: distances to the tool.
  void bindTable() const;
  /// For tissue programs that use the tool; to_tool is toApproach().
  void setUniforms(const GlProgram& program, const FrameView& view, const LiveFrame& frame) const;

  void draw(const FrameView& view, const LiveFrame& frame, const Rigid3& T_world_tool) const;
  /// Draws on top of everything. Leaves depth test and blending off.   @param flat  draws FlatCorners.
  void drawAxisLine(const GlProgram& flat, const FrameView& view, const LiveFrame& frame,
                    const Rigid3& T_world_tool) const;

 private:
  void setTable(const ToolLook& look);
  Rigid3 approachPose(const Rigid3& T_world_tool) const;

  GlProgram steel_;
  GLuint array_ = 0, buffer_ = 0, table_texture_ = 0, line_array_ = 0, line_buffer_ = 0;
  GLsizei corners_ = 0;
  Box3 box_;         // tool frame
  ToolTable table_;  // without its distances
};

}  // namespace internal
}  // namespace kerf
