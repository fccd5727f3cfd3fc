// The mesher's thread: takes changed bricks from a BrickFeed and hands changed chunks of the mesh to the window.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_map>
#include <vector>

#include "sim/live/remesher.h"
#include "sim/object/brick_feed.h"
#include "sim/pieces/piece_origin.h"

namespace kerf {

struct MesherThreadOptions {
  RemesherOptions remesher;
  /// Pause after the feed was found empty: adds at most that much to the delay of the picture. Below 0.1 ms the thread
  /// takes a whole core; above 5 ms the surface visibly lags.
  std::chrono::microseconds poll{1000};
};

/// Runs a Remesher on a thread of its own. It never waits for the producer of the feed, nor the producer for it: they
/// share the feed's two counters and nothing else. The reader and the mesher share a mutex, which is locked while a few
/// pointers change hands.
///
/// The chunks of one take() belong together: a reader that replaces older chunks by them, brick by brick, has the
/// closed mesh of one state of the mesher's replica after each take().
class MesherThread {
 public:
  /// Starts at once. The first take() that gives anything gives the whole baked surface.
  /// @param phi0, feed  kept by reference, must outlive this. This thread is the feed's consumer.
  MesherThread(const BrickField& phi0, BrickFeed& feed, const MesherThreadOptions& options = {});
  /// Of a piece: its field is made on this thread first.   @param feed  what on_piece gave with it: shared with the
  /// maker of pieces as long as the piece may be in the scene.
  MesherThread(std::shared_ptr<const PieceOrigin> piece, std::shared_ptr<BrickFeed> feed,
               const MesherThreadOptions& options = {});
  /// Stops as stop() does.
  ~MesherThread();
  MesherThread(const MesherThread&) = delete;
  MesherThread& operator=(const MesherThread&) = delete;

  /// Chunks that changed since the last take(), the newest of each brick, in order of brick; an empty chunk says that
  /// no surface is left there. One reader. O(what changed); waits for the mesher at most while it hands over pointers.
  std::vector<MeshChunkPtr> take();
  /// Edits meshed so far: with the producer's count of successful pushes it tells how far the mesh lags behind.
  std::uint64_t editsDone() const noexcept { return edits_done_.load(std::memory_order_acquire); }

  /// The bricks that differ from phi0, as this thread knows them when it has taken all that is in the feed. Any thread;
  /// waits for other callers and for the mesher: some ms, for a piece that has just come off until it is meshed.
  /// None: it has stopped.
  std::optional<BrickField> changedField();
  bool isPiece() const noexcept { return shared_feed_ != nullptr; }
  /// Of a piece: its field as it came off; null until it is made, which is before the first changedField() returns.
  std::shared_ptr<const BrickField> pieceField() const;
  /// Nobody else has the feed any more: the piece will not be seen again.
  bool isForgotten() const noexcept { return shared_feed_ && shared_feed_.use_count() == 1; }

  /// Meshes what is in the feed by now and ends the thread; take() then gives the rest. May be called again.
  /// The producer should push no more: what comes later stays in the feed.
  void stop();

 private:
  void run(const BrickField& phi0);
  void publish(const std::vector<MeshChunkPtr>& chunks);
  bool isCopyWanted() const;
  void giveCopy(const BrickField& changed);

  std::shared_ptr<BrickFeed> shared_feed_;  // of a piece
  BrickFeed& feed_;
  MesherThreadOptions options_;
  std::shared_ptr<const BrickField> piece_field_;  // made by the thread, before any copy; guarded by mutex_
  std::atomic<bool> is_stopping_{false};
  std::atomic<std::uint64_t> edits_done_{0};
  std::mutex asking_;  // one caller of changedField() at a time; before mutex_
  mutable std::mutex mutex_;
  std::condition_variable copied_;
  bool is_copy_wanted_ = false, is_over_ = false;          // guarded by mutex_
  std::optional<BrickField> copy_;                         // guarded by mutex_
  std::unordered_map<std::uint64_t, MeshChunkPtr> fresh_;  // by key of the brick; guarded by mutex_
  std::thread thread_;                                     // last: everything above exists before it starts
};

}  // namespace kerf
