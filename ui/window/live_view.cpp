#include "ui/window/live_view.h"

#include <utility>

#include "ui/app/sawing.h"
#include "ui/app/tissue_display.h"

namespace kerf {

Expected<std::unique_ptr<LiveView>> LiveView::create() {
  KERF_TRY(renderer, LiveRenderer::create());
  return std::unique_ptr<LiveView>(new LiveView(std::move(renderer)));
}

void LiveView::update(Workbench& bench) {
  const std::vector<ObjectChunks> changed = bench.update();
  if (bench.generation() != generation_) {
    if (before_clear_) before_clear_();
    generation_ = bench.generation();
    renderer_->clear();
    placed_.clear();
    sections_.clear();
    tool_.reset();
    hover_.reset();
    is_fit_wanted_ = !bench.keepsView();
  }
  for (const ObjectChunks& object : changed)
    for (const MeshChunkPtr& chunk : object.chunks)
      renderer_->setChunk(object.id, *chunk, chunk->colours, chunk->occlusion);
  placeObjects(bench.scene());
  showSection(bench);
  saw_.surfaceChanged(!changed.empty());
  showTool(bench);
}

void LiveView::placeObjects(const LiveScene& scene) {
  for (const std::uint32_t id : std::exchange(placed_, {})) renderer_->setVisible(id, false);
  for (const SceneObject* object : scene.shown()) {
    renderer_->setPose(object->id, object->pose());
    renderer_->setVisible(object->id, !object->is_hidden);
    placed_.push_back(object->id);
  }
}

// What is made of what, anew for an object when the plane has moved through it.
void LiveView::showSection(const Workbench& bench) {
  if (!bench.section) return;
  for (const SceneObject* object : bench.scene().shown()) {
    if (object->is_hidden) continue;
    const Rigid3 to_object = object->pose().inverse();
    const Plane local{to_object * bench.section->point, to_object.rotation * bench.section->normal};
    const auto known = sections_.find(object->id);
    if (known != sections_.end() && known->second.point == local.point && known->second.normal == local.normal)
      continue;
    sections_[object->id] = local;
    renderer_->setSection(object->id, bench.tissues().sectionAt(local));
  }
}

bool LiveView::takeFitWanted() { return std::exchange(is_fit_wanted_, false); }

void LiveView::showTool(const Workbench& bench) {
  if (!bench.isOpen() || tool_ == bench.toolInHand()) return;
  tool_ = bench.toolInHand();
  const Tool& tool = bench.tool(*tool_);
  ToolLook look;
  look.mesh = toolMesh(tool, 0.02);
  look.cutting = tool.cut->bounds();
  look.approach = tool.plunge_direction;
  look.distance = [cut = tool.cut](const Vec3d& p) { return cut->distance(p); };
  renderer_->setTool(look);
}

LiveFrame LiveView::frameOf(const Workbench& bench, const Camera& camera) {
  LiveFrame frame;
  if (!bench.isOpen()) return frame;
  frame.section = bench.section;
  frame.plan = saw_.planOf(bench, camera);
  if (bench.isPressed() || bench.saw().isCutting()) {
    frame.T_world_tool = bench.report().output.T_world_tool;
  } else if (hover_) {
    frame.T_world_tool = hover_->T_world_tool;
    frame.is_ghost = true;
  }
  return frame;
}

Expected<void> LiveView::draw(const Workbench& bench, const Camera& camera, int width, int height, bool is_still) {
  LiveFrame frame = frameOf(bench, camera);
  frame.supersampling = is_still ? 2 : 1;
  return renderer_->draw(camera, width, height, frame);
}

Expected<Image> LiveView::picture(const Workbench& bench, const Camera& camera, int width, int height) {
  LiveFrame frame = frameOf(bench, camera);
  frame.supersampling = 2;
  return renderer_->picture(camera, width, height, frame);
}

}  // namespace kerf
