#include "ui/window/draw/import_view.h"

#include <algorithm>
#include <utility>

#include "ui/app/import/import_mesh.h"

namespace kerf {
namespace {

constexpr std::size_t kTrianglesAFrame = 150'000;  // copied to the renderer: about 10 ms

}  // namespace

Expected<std::unique_ptr<ImportView>> ImportView::create() {
  KERF_TRY(renderer, LiveRenderer::create());
  return std::unique_ptr<ImportView>(new ImportView(std::move(renderer)));
}

void ImportView::start(const ImportPicture& picture) {
  waiting_.clear();
  job_ = std::make_unique<Job<Chunks>>("showing the scan", [picture](const Progress& progress) {
    const Mesh all = meshOf(picture);
    if (!report(progress, 0.3, "chunks")) return Expected<Chunks>(cancelled());
    return Expected<Chunks>(chunksOf(all, std::max(2.0, picture.box.size().norm() / 40)));
  });
}

void ImportView::update(const std::optional<ImportPicture>& picture) {
  std::erase_if(ending_, [](const auto& job) { return job->isOver(); });
  if (!picture) {
    if (!of_.empty()) renderer_->clear();
    of_.clear();
    fitted_.clear();
    wanted_.clear();
    if (job_) ending_.push_back(std::move(job_));  // waiting would delay the frame
    waiting_.clear();
    shown_ = kNone;
    return;
  }

  const bool is_other = picture->of != of_ || picture->parts != wanted_;
  // An outdated job ends by itself: waiting would delay the frame.
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
  KERF_CHECK(renderer_->draw(camera, width, height, frame));
  drawn_ = {renderer_->version(), camera, width, height, frame};
  is_drawn_still_ = is_still;
  return {};
}

bool ImportView::isDrawn(const Camera& camera, int width, int height, bool is_still) const {
  const PictureContent now{renderer_->version(), camera, width, height, {}};
  return is_still == is_drawn_still_ && renderer_->counts().waiting_pages == 0 && drawn_.isSame(now);
}

}  // namespace kerf
