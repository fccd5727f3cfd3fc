#include "ui/window/draw/live_view.h"

#include <cstdint>
#include <utility>

#include "ui/app/document/document.h"
#include "ui/app/document/view_state.h"
#include "ui/app/tool/tool_look.h"
#include "ui/app/view/piece_colours.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"

namespace kerf {
namespace {

constexpr std::size_t kUploadAFrame = 1'000'000;  // bytes: some 15 ms in software; 300 000 triangles take 7 frames

/// Renderer's number of a part of an object; objects themselves have the number of their id.
std::size_t numberOf(std::uint32_t object, TissuePart part) {
  return object + (std::size_t{part == TissuePart::kSolid ? 1u : 2u} << 32);
}

constexpr std::size_t kAsLoaded = std::size_t{3} << 32;  // the object as loaded

// Parts of tissues have numbers beyond those of objects.
bool isBeside(const Workbench& bench, std::size_t object) {
  if (!bench.document->run() || bench.document->run()->neighbours().empty() || object > UINT32_MAX) return false;
  return bench.document->run()->isBeside(static_cast<std::uint32_t>(object));
}

}  // namespace

Expected<std::unique_ptr<LiveView>> LiveView::create() {
  KERF_TRY(renderer, LiveRenderer::create());
  return std::unique_ptr<LiveView>(new LiveView(std::move(renderer)));
}

void LiveView::update(Workbench& bench) {
  const std::vector<ObjectChunks> changed = bench.update();
  if (bench.document->generation() != generation_) {
    if (before_clear_) before_clear_();
    generation_ = bench.document->generation();
    renderer_->clear();
    placed_.clear();
    sections_.clear();
    parts_.clear();
    has_as_loaded_ = false;
    known_.clear();
    is_whole_wanted_ = false;
    tints_.clear();
    posed_.clear();
    tool_.reset();
    hover_.reset();
    is_fit_wanted_ = !bench.document->keepsView();
  }
  lookForPieces(bench, changed);
  for (const ObjectChunks& object : changed)
    for (const MeshChunkPtr& chunk : object.chunks) setChunk(bench, object.id, *chunk);
  takeTissues(bench);
  recolour(bench);
  takeAsLoaded(bench);
  tintPieces(bench);
  showContacts(bench);
  placeObjects(bench);
  showSection(bench);
  saw_.surfaceChanged(!changed.empty());
  showTool(bench);
}

// A new piece is no longer in its parent's surface: it must not be missing until its upload.
void LiveView::lookForPieces(const Workbench& bench, const std::vector<ObjectChunks>& changed) {
  for (const ObjectChunks& object : changed) {
    if (object.chunks.empty() || known_.contains(object.id)) continue;
    is_whole_wanted_ |= !known_.empty() && !isUploading() && !isBeside(bench, object.id);
    known_.insert(object.id);
  }
}

// Maps cover the object to cut. Their colours are values, so pieces keep their hue.
void LiveView::setChunk(const Workbench& bench, std::size_t object, const MeshChunk& chunk) {
  if (isBeside(bench, object))
    return renderer_->setChunk(object, chunk, bench.views->tissues().coloursBeside(chunk), chunk.occlusion);
  const auto posed = posed_.find(static_cast<std::uint32_t>(object & UINT32_MAX));
  const Rigid3 pose = posed == posed_.end() || object == kAsLoaded ? Rigid3{} : posed->second;
  std::vector<Rgba8> colours = bench.views->tissues().coloursOf(chunk, pose);
  const auto tinted = tints_.find(static_cast<std::uint32_t>(object & UINT32_MAX));
  if (tinted != tints_.end() && object != kAsLoaded && !bench.views->tissues().isMap())
    if (const PieceColour* const colour = findPieceColour(tinted->second)) tint(colours, *colour);
  renderer_->setChunk(object, chunk, colours, chunk.occlusion);
}

void LiveView::takeTissues(Workbench& bench) {
  for (const TissueDisplay::Change& change : bench.views->tissues().takeChanges()) {
    const std::size_t number = numberOf(change.object, change.part);
    if (change.is_new) {
      is_whole_wanted_ |= !isUploading();
      renderer_->removeObject(number);
      parts_[number].clear();
      sections_.erase(number);
    }
    parts_[number].update(change.chunks);
    for (const MeshChunkPtr& chunk : change.chunks) setChunk(bench, number, *chunk);
  }
  if (!bench.views->tissues().areAllShown()) return;
  is_whole_wanted_ |= !parts_.empty();  // while its parts were shown, the surface itself was uploaded last
  for (const auto& [number, surface] : std::exchange(parts_, {})) {
    renderer_->removeObject(number);
    sections_.erase(number);
  }
}

// Uploaded over several frames before it is seen.
void LiveView::takeAsLoaded(const Workbench& bench) {
  const auto* const chunks = bench.views->tissues().asLoaded();
  if (!chunks || !bench.views->tissues().isAsLoadedShown() || std::exchange(has_as_loaded_, true)) return;
  for (const MeshChunkPtr& chunk : *chunks) setChunk(bench, kAsLoaded, *chunk);
  renderer_->setVisible(kAsLoaded, false);
  is_as_loaded_whole_ = false;
}

bool LiveView::isAsLoadedDrawn(const Workbench& bench) const {
  return has_as_loaded_ && is_as_loaded_whole_ && bench.views->tissues().isAsLoadedShown();
}

// Another map: recomputes all colours.
void LiveView::recolour(const Workbench& bench) {
  if (std::exchange(colours_version_, bench.views->tissues().coloursVersion()) ==
      bench.views->tissues().coloursVersion())
    return;
  for (const SceneObject* object : bench.document->scene().shown()) recolour(bench, *object);
  has_as_loaded_ = false;
}

void LiveView::recolour(const Workbench& bench, const SceneObject& object) {
  object.surface.forEachChunk([&](const MeshChunk& chunk) { setChunk(bench, object.id, chunk); });
  for (const auto& [number, surface] : parts_)
    if (static_cast<std::uint32_t>(number & UINT32_MAX) == object.id)
      surface.forEachChunk([&, n = number](const MeshChunk& chunk) { setChunk(bench, n, chunk); });
}

// A piece with a colour chosen by the user.
void LiveView::tintPieces(const Workbench& bench) {
  for (const SceneObject* object : bench.document->scene().shown()) {
    std::string& tint = tints_[object->id];
    if (tint == object->colour) continue;
    tint = object->colour;
    recolour(bench, *object);
  }
}

// A moved piece has other contacts. During a drag it keeps those of its old place.
void LiveView::showContacts(const Workbench& bench) {
  if (bench.views->tissues().colours() != SurfaceColours::kContact) return;
  for (const SceneObject* object : bench.document->scene().shown()) {
    Rigid3& pose = posed_[object->id];
    const Rigid3& now = object->T_world_object;
    if (object->isBeside() || (pose.translation == now.translation && pose.rotation.coeffs() == now.rotation.coeffs()))
      continue;
    pose = now;
    recolour(bench, *object);
  }
}

void LiveView::place(std::size_t object, const Rigid3& pose, bool is_visible, bool is_ghost) {
  renderer_->setPose(object, pose);
  renderer_->setVisible(object, is_visible);
  renderer_->setGhost(object, is_ghost);
  placed_.push_back(object);
}

void LiveView::placeObjects(const Workbench& bench) {
  for (const std::size_t number : std::exchange(placed_, {})) renderer_->setVisible(number, false);
  const TissueDisplay& tissues = bench.views->tissues();
  const bool has_solid = tissues.hasPart(TissuePart::kSolid), is_ghost = tissues.isOwnSurfaceGhost();
  const bool is_as_loaded = isAsLoadedDrawn(bench);
  if (is_as_loaded) place(kAsLoaded, {}, true, false);
  for (const SceneObject* object : bench.document->scene().shown()) {
    const bool is_seen = !object->is_hidden && (object->isBeside() || !is_as_loaded);
    if (object->isBeside()) {
      place(object->id, object->pose(), is_seen, object->is_ghost);
      continue;
    }
    place(object->id, object->pose(), is_seen && (!has_solid || is_ghost), is_ghost);
    for (const TissuePart part : {TissuePart::kSolid, TissuePart::kGhost})
      if (tissues.hasPart(part)) place(numberOf(object->id, part), object->pose(), is_seen, part == TissuePart::kGhost);
  }
}

// Materials in the plane, recomputed for an object when the plane has moved through it.
void LiveView::showSection(const Workbench& bench) {
  if (!bench.views->section) return;
  const bool has_parts = bench.views->tissues().hasPart(TissuePart::kSolid);
  const auto show = [&](std::size_t number, const Rigid3& pose, std::size_t loaded) {
    const Rigid3 to_object = pose.inverse();
    const Plane local{to_object * bench.views->section->point, to_object.rotation * bench.views->section->normal};
    const auto known = sections_.find(number);
    if (known != sections_.end() && known->second.point == local.point && known->second.normal == local.normal) return;
    sections_[number] = local;
    renderer_->setSection(number, bench.views->tissues().sectionAt(local, loaded));
  };
  if (isAsLoadedDrawn(bench)) show(kAsLoaded, {}, 0);
  for (const SceneObject* object : bench.document->scene().shown()) {
    if (object->is_hidden) continue;
    const bool is_part = has_parts && !object->isBeside();
    show(is_part ? numberOf(object->id, TissuePart::kSolid) : object->id, object->pose(), object->loaded);
  }
}

bool LiveView::takeFitWanted() { return std::exchange(is_fit_wanted_, false); }

void LiveView::showTool(const Workbench& bench) {
  if (!bench.document->isShown() || tool_ == bench.tools->inHand()) return;
  tool_ = bench.tools->inHand();
  renderer_->setTool(lookOf(bench.tools->at(*tool_)));
}

LiveFrame LiveView::frameOf(const Workbench& bench, const Camera& camera) {
  LiveFrame frame;
  if (!bench.document->isShown()) return frame;
  frame.section = bench.views->section;
  frame.plan = saw_.planOf(bench, camera);
  if (bench.document->watched() || bench.strokes->isPressed() || bench.device->isLed() || bench.saw->isCutting()) {
    frame.T_world_tool = bench.document->report().output.T_world_tool;
  } else if (hover_ && !isAsLoadedDrawn(bench)) {
    frame.T_world_tool = hover_->T_world_tool;
    frame.is_ghost = true;
  }
  return frame;
}

Expected<void> LiveView::draw(const Workbench& bench, const Camera& camera, int width, int height, Edges edges) {
  LiveFrame frame = frameOf(bench, camera);
  frame.supersampling = edges == Edges::kSmooth ? 2 : 1;
  if (!std::exchange(is_whole_wanted_, false)) frame.most_upload = kUploadAFrame;
  drawn_.reset();
  if (edges == Edges::kByAndBy) {
    KERF_CHECK(still_.draw(*renderer_, camera, width, height, frame));
  } else {
    still_.forget();
    KERF_CHECK(renderer_->draw(camera, width, height, frame));
  }
  is_as_loaded_whole_ |= !isUploading();
  const bool is_final = edges == Edges::kSmooth || (edges == Edges::kByAndBy && still_.isFinal());
  if (is_final && !isUploading()) drawn_ = PictureContent{renderer_->version(), camera, width, height, frame};
  return {};
}

bool LiveView::isDrawn(const Workbench& bench, const Camera& camera, int width, int height, Edges edges) {
  if (!drawn_ || edges == Edges::kFast || is_whole_wanted_) return false;
  return drawn_->isSame({renderer_->version(), camera, width, height, frameOf(bench, camera)});
}

Expected<Image> LiveView::picture(const Workbench& bench, const Camera& camera, int width, int height) {
  if (!std::exchange(is_as_loaded_whole_, true)) {
    placeObjects(bench);
    showSection(bench);
  }
  LiveFrame frame = frameOf(bench, camera);
  frame.supersampling = 2;
  return renderer_->picture(camera, width, height, frame);
}

}  // namespace kerf
