#include "ui/window/import_view.h"

#include <algorithm>
#include <utility>

namespace kerf {
namespace {

constexpr std::size_t kTrianglesAFrame = 150'000;  // copied to the renderer: about 10 ms
constexpr Rgba8 kScanColour = {233, 221, 197, 255};
constexpr Rgba8 kInsideColour = {150, 138, 132, 255};  // of a scan that is open: its hollow underside

// A colour for each face: what is joined has all or none.
void colourFaces(Mesh& mesh) {
  if (mesh.hasFaceColors()) return;
  mesh.face_colors.assign(mesh.triangles.size(), kScanColour);
  for (std::size_t t = 0; mesh.hasVertexColors() && t < mesh.triangles.size(); ++t)
    mesh.face_colors[t] = mesh.vertex_colors[mesh.triangles[t][0]];
  mesh.vertex_colors.clear();
}

// Half way to a bluish grey.
void makePale(Mesh& mesh) {
  constexpr Rgba8 kPale = {150, 165, 185, 255};
  for (Rgba8& colour : mesh.face_colors)
    for (std::size_t n = 0; n < 3; ++n)
      colour[n] = static_cast<std::uint8_t>((static_cast<int>(colour[n]) + static_cast<int>(kPale[n])) / 2);
}

// With its inside, which the renderer draws only as triangles of their own.
Mesh withInside(Mesh mesh) {
  Mesh inside = mesh;
  for (Triangle& t : inside.triangles) std::swap(t[1], t[2]);
  inside.vertex_colors.clear();
  inside.face_colors.assign(inside.triangles.size(), kInsideColour);
  colourFaces(mesh);
  append(mesh, inside);
  return mesh;
}

}  // namespace

Expected<std::unique_ptr<ImportView>> ImportView::create() {
  KERF_TRY(renderer, LiveRenderer::create());
  return std::unique_ptr<ImportView>(new ImportView(std::move(renderer)));
}

void ImportView::start(const ImportPicture& picture) {
  waiting_.clear();
  job_ = std::make_unique<Job<Chunks>>(
      "showing the scan", [parts = picture.parts, across = picture.box.size().norm()](const Progress& progress) {
        Mesh all;
        for (const ImportPicture::Part& part : parts) {
          Mesh shown = *part.mesh;
          for (Vec3d& p : shown.vertices) p *= part.scale_to_mm;
          if (part.is_open) shown = withInside(std::move(shown));
          const bool is_first = all.triangles.empty();
          if (part.is_beside || parts.size() > 1) colourFaces(shown);
          if (part.is_beside) makePale(shown);
          if (is_first)
            all = std::move(shown);
          else
            append(all, shown);
        }
        if (!report(progress, 0.3, "chunks")) return Expected<Chunks>(cancelled());
        return Expected<Chunks>(chunksOf(all, std::max(2.0, across / 40)));
      });
}

void ImportView::update(const std::optional<ImportPicture>& picture) {
  std::erase_if(ending_, [](const auto& job) { return job->isOver(); });
  if (!picture) {
    if (!of_.empty()) renderer_->clear();
    of_.clear();
    fitted_.clear();
    wanted_.clear();
    if (job_) ending_.push_back(std::move(job_));  // waiting for it here would hold up the frame
    waiting_.clear();
    shown_ = kNone;
    return;
  }

  const bool is_other = picture->of != of_ || picture->parts != wanted_;
  // A job that is outdated ends by itself: waiting for it here would hold up the frame.
  if (is_other && !picture->parts.empty() && (!job_ || job_->isOver())) {
    of_ = picture->of;
    wanted_ = picture->parts;
    start(*picture);
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
  if (std::exchange(fitted_, of_) != of_) is_fit_wanted_ = true;
}

bool ImportView::takeFitWanted() { return std::exchange(is_fit_wanted_, false); }

Expected<void> ImportView::draw(const Camera& camera, int width, int height, bool is_still) {
  LiveFrame frame;
  frame.supersampling = is_still ? 2 : 1;
  return renderer_->draw(camera, width, height, frame);
}

}  // namespace kerf
