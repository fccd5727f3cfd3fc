#include "ui/app/document/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/run/session/watched_run.h"

namespace kerf {

namespace fs = std::filesystem;

Document::Document(Notices& notices) : notices_(notices) {
  if (auto materials = readDefaultMaterials())
    materials_ = std::move(*materials);
  else
    notices_.complain(materials.error());
}

Document::~Document() = default;

std::string Document::nameOf(Material material) const {
  const MaterialProperties* const known = materials_.find(material);
  return known ? known->name : fmt::format("material {}", static_cast<int>(material));
}

double Document::removedOf(Material material) const {
  const auto number = static_cast<std::size_t>(material);
  return isShown() && number < report_.removed_by_material.size() ? report_.removed_by_material[number] : 0;
}

bool Document::isNeighbourTowards(const Vec3d& direction) const {
  std::vector<std::shared_ptr<const BakedObject>> objects;
  if (watched_) objects.assign(watched_->objects().begin(), watched_->objects().end());
  if (run_) {
    objects.push_back(run_->sharedObject());
    for (const LiveNeighbour& other : run_->neighbours()) objects.push_back(other.object);
  }
  return std::any_of(objects.begin(), objects.end(), [&](const auto& object) {
    const Vec3d way = object->phi0().bounds().center() - objects.front()->phi0().bounds().center();
    return way.dot(direction) > std::sqrt(0.5) * way.norm();
  });
}

bool Document::send(const Command& command) {
  if (!run_->send(command)) return false;
  ++sent_;
  return true;
}

// ---- Opening and ending

void Document::forget() {
  report_ = {};
  times_ = {};
  removed_mm3_ = 0;
  sent_ = 0;
  has_news_ = has_told_of_log_ = false;
  fresh_.clear();
  scene_.clear();
}

void Document::open(Opened loaded, Hands hands, Opening how) {
  forget();
  watched_.reset();
  hands_ = std::move(hands);
  run_ = std::move(loaded.run);
  structures_ = std::move(loaded.structures);
  neighbour_fields_ = std::move(loaded.neighbours);
  sources_beside_ = std::move(loaded.sources_beside);
  name_ = std::move(loaded.name);
  source_ = std::move(loaded.source);
  occlusal_ = loaded.occlusal;
  if (how == Opening::kNew) prepared_ = std::move(loaded.prepared);
  session_ = run_->folder();
  scene_.setLabels(run_->labels());
  keeps_view_ = how == Opening::kReopened;
  ++generation_;
}

void Document::watch(std::unique_ptr<WatchedRun> run, const OcclusalSide& occlusal) {
  forget();
  watched_ = std::move(run);
  structures_ = watched_->structures();
  name_ = fs::path(watched_->manifest().case_path).stem().string();
  source_ = watched_->folder();
  occlusal_ = occlusal;
  scene_.setLabels(watched_->labels());
  keeps_view_ = false;
  ++generation_;
}

EndingRun Document::end() {
  scene_.clear();
  ++generation_;
  return {std::move(hands_), std::move(run_), sent_, name_, session_};
}

void Document::endWatching() {
  forget();
  watched_.reset();
  structures_.reset();
  ++generation_;
}

// ---- Once a frame

void Document::update() {
  has_news_ = false;
  if (watched_)
    takeWatched();
  else if (run_)
    takeRun();
}

void Document::takeRun() {
  if (run_->thread().update()) {
    has_news_ = true;
    report_ = run_->thread().report();
    removed_mm3_ = run_->removedBefore();
    for (std::size_t n = 0; n < report_.object_count; ++n)
      if (report_.objects[n].loaded == 0) removed_mm3_ += report_.objects[n].removed_mm3;
  }
  if (run_->thread().updateTimes()) times_ = run_->thread().times();
  const auto chunks = run_->takeChunks();
  scene_.update(chunks, report_);
  fresh_.insert(fresh_.end(), chunks.begin(), chunks.end());

  const RecorderStatus log = run_->recorderStatus();
  if (!log.error || std::exchange(has_told_of_log_, true)) return;
  Error error = *log.error;
  error.hint = "free disk space and end the session: your cuts are kept, the log ends here";
  notices_.complain(error);
}

void Document::takeWatched() {
  if (watched_->update()) {
    has_news_ = true;
    report_ = watched_->moment().report;
    removed_mm3_ = watched_->removedBefore();
    for (std::size_t n = 0; n < report_.object_count; ++n) removed_mm3_ += report_.objects[n].removed_mm3;
  }
  const auto chunks = watched_->takeChunks();
  scene_.update(chunks, report_);
  fresh_.insert(fresh_.end(), chunks.begin(), chunks.end());
}

std::vector<ObjectChunks> Document::takeChunks() { return std::exchange(fresh_, {}); }

}  // namespace kerf
