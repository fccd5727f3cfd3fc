#include "ui/window/import_view.h"

#include <algorithm>
#include <utility>

namespace kerf {
namespace {

constexpr std::size_t kTrianglesAFrame = 150'000;  // copied to the renderer: about 10 ms
constexpr Rgba8 kScanColour = {233, 221, 197, 255};
constexpr Rgba8 kInsideColour = {150, 138, 132, 255};  // of a scan that is open: its hollow underside

// With its inside, which the renderer draws only as triangles of their own.
Mesh withInside(Mesh mesh) {
  Mesh inside = mesh;
  for (Triangle& t : inside.triangles) std::swap(t[1], t[2]);
  inside.vertex_colors.clear();
  inside.face_colors.assign(inside.triangles.size(), kInsideColour);
  if (!mesh.hasFaceColors()) {
    mesh.face_colors.assign(mesh.triangles.size(), kScanColour);
    for (std::size_t t = 0; mesh.hasVertexColors() && t < mesh.triangles.size(); ++t)
      mesh.face_colors[t] = mesh.vertex_colors[mesh.triangles[t][0]];
    mesh.vertex_colors.clear();
  }
  append(mesh, inside);
  return mesh;
}

}  // namespace

Expected<std::unique_ptr<ImportView>> ImportView::create() {
  KERF_TRY(renderer, LiveRenderer::create());
  return std::unique_ptr<ImportView>(new ImportView(std::move(renderer)));
}

void ImportView::start(const ImportPlan& plan, bool shows_solid) {
  const std::shared_ptr<const Mesh> mesh = shows_solid ? plan.preview()->solid : plan.found().mesh;
  const double scale = shows_solid ? 1 : plan.unit().scale_to_mm;
  const bool is_open = !shows_solid && !plan.found().check.isClosed();
  const double across = plan.boxMm().size().norm();
  waiting_.clear();
  job_ = std::make_unique<Job<Chunks>>("showing the scan", [mesh, scale, is_open, across](const Progress& progress) {
    Mesh shown = *mesh;
    for (Vec3d& p : shown.vertices) p *= scale;
    if (is_open) shown = withInside(std::move(shown));
    if (!report(progress, 0.3, "chunks")) return Expected<Chunks>(cancelled());
    return Expected<Chunks>(chunksOf(shown, std::max(2.0, across / 40)));
  });
}

void ImportView::update(const ImportPlan* plan, bool shows_solid) {
  std::erase_if(ending_, [](const auto& job) { return job->isOver(); });
  if (!plan) {
    if (plan_) renderer_->clear();
    plan_ = nullptr;
    wanted_ = nullptr;
    if (job_) ending_.push_back(std::move(job_));  // waiting for it here would hold up the frame
    waiting_.clear();
    shown_ = kNone;
    fitted_scale_ = 0;
    return;
  }

  const bool is_solid = shows_solid && plan->preview();
  const Mesh* const mesh = is_solid ? plan->preview()->solid.get() : plan->found().mesh.get();
  const double scale = plan->unit().scale_to_mm;
  const bool is_other = plan != plan_ || mesh != wanted_ || scale != wanted_scale_;
  // A job that is outdated ends by itself: waiting for it here would hold up the frame.
  if (is_other && (!job_ || job_->isOver())) {
    plan_ = plan;
    wanted_ = mesh;
    wanted_scale_ = scale;
    start(*plan, is_solid);
  }
  if (job_ && job_->isOver()) {
    if (auto chunks = job_->take()) waiting_ = std::move(*chunks);
    job_.reset();
    next_ = 0;
  }
  handOver();
}

void ImportView::handOver() {
  if (waiting_.empty()) return;
  const std::size_t hidden = shown_ == 0 ? 1 : 0;
  if (next_ == 0) renderer_->setVisible(hidden, false);
  for (std::size_t triangles = 0; next_ < waiting_.size() && triangles < kTrianglesAFrame; ++next_) {
    const ColouredChunk& c = waiting_[next_];
    renderer_->setChunk(hidden, c.chunk, c.colours);
    triangles += c.chunk.triangles.size();
  }
  if (next_ < waiting_.size()) return;

  waiting_.clear();
  renderer_->setVisible(hidden, true);
  if (shown_ != kNone) renderer_->removeObject(shown_);
  shown_ = hidden;
  if (std::exchange(fitted_scale_, wanted_scale_) != wanted_scale_) is_fit_wanted_ = true;
}

bool ImportView::takeFitWanted() { return std::exchange(is_fit_wanted_, false); }

Expected<void> ImportView::draw(const Camera& camera, int width, int height, bool is_still) {
  LiveFrame frame;
  frame.supersampling = is_still ? 2 : 1;
  return renderer_->draw(camera, width, height, frame);
}

}  // namespace kerf
