#include "sim/live/mesher_thread.h"

#include <algorithm>
#include <utility>

namespace kerf {

MesherThread::MesherThread(const BrickField& phi0, BrickFeed& feed, const MesherThreadOptions& options)
    : feed_(feed), options_(options), thread_([this, &phi0] { run(phi0); }) {}

MesherThread::MesherThread(std::shared_ptr<const PieceOrigin> piece, std::shared_ptr<BrickFeed> feed,
                           const MesherThreadOptions& options)
    : shared_feed_(std::move(feed)), feed_(*shared_feed_), options_(options), thread_([this, piece = std::move(piece)] {
        auto field = std::make_shared<const BrickField>(piece->field());
        {
          const std::lock_guard lock(mutex_);
          piece_field_ = field;
        }
        run(*field);
      }) {}

MesherThread::~MesherThread() { stop(); }

void MesherThread::stop() {
  is_stopping_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void MesherThread::run(const BrickField& phi0) {
  Remesher remesher(phi0, options_.remesher);
  publish(remesher.changedSince(0));
  std::vector<BrickEdit> edits;
  int idle = 0;  // polls without edits
  for (;;) {
    // Read both before the feed is emptied: bricks pushed before stop() are still meshed, and a requested copy has all
    // bricks pushed before the request.
    const bool is_last = is_stopping_.load(std::memory_order_acquire), is_wanted = isCopyWanted();
    edits.clear();
    if (feed_.drain(edits) > 0) {
      const std::uint64_t before = remesher.version();
      remesher.apply(edits);
      publish(remesher.changedSince(before));
      edits_done_.fetch_add(edits.size(), std::memory_order_release);
      idle = 0;
    } else if (!is_last) {
      constexpr int kIdle = 1000, kSlower = 5;  // a third of a frame late at most
      idle = std::min(idle + 1, kIdle);
      std::this_thread::sleep_for(idle < kIdle ? options_.poll : kSlower * options_.poll);
    }
    if (is_wanted) giveCopy(remesher.field().changed());
    if (is_last) break;
  }
  const std::lock_guard lock(mutex_);
  is_over_ = true;
  copied_.notify_one();
}

std::optional<BrickField> MesherThread::changedField() {
  const std::lock_guard one(asking_);
  std::unique_lock lock(mutex_);
  is_copy_wanted_ = true;
  copied_.wait(lock, [this] { return copy_.has_value() || is_over_; });
  is_copy_wanted_ = false;
  return std::exchange(copy_, std::nullopt);
}

std::shared_ptr<const BrickField> MesherThread::pieceField() const {
  const std::lock_guard lock(mutex_);
  return piece_field_;
}

bool MesherThread::isCopyWanted() const {
  const std::lock_guard lock(mutex_);
  return is_copy_wanted_;
}

void MesherThread::giveCopy(const BrickField& changed) {
  const std::lock_guard lock(mutex_);
  is_copy_wanted_ = false;
  copy_ = changed;
  copied_.notify_one();
}

void MesherThread::publish(const std::vector<MeshChunkPtr>& chunks) {
  if (chunks.empty()) return;
  std::vector<MeshChunkPtr> outdated;  // declared before the lock: freed after it
  outdated.reserve(chunks.size());
  const std::lock_guard lock(mutex_);
  for (const MeshChunkPtr& c : chunks) {
    MeshChunkPtr& slot = fresh_[coordKey(c->brick)];
    if (slot) outdated.push_back(std::move(slot));
    slot = c;
  }
}

std::vector<MeshChunkPtr> MesherThread::take() {
  std::unordered_map<std::uint64_t, MeshChunkPtr> taken;
  {
    const std::lock_guard lock(mutex_);
    taken.swap(fresh_);
  }
  std::vector<MeshChunkPtr> out;
  out.reserve(taken.size());
  for (auto& [key, chunk] : taken) out.push_back(std::move(chunk));
  std::sort(out.begin(), out.end(),
            [](const MeshChunkPtr& a, const MeshChunkPtr& b) { return coordKey(a->brick) < coordKey(b->brick); });
  return out;
}

}  // namespace kerf
