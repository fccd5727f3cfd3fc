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
  /// Pause after an empty feed: delays the picture by at most this. Below 0.1 ms the thread takes a whole core; above 5
  /// ms the surface visibly lags.
  std::chrono::microseconds poll{1000};
};

/// Runs a Remesher on a thread of its own. The thread and the producer of the feed never wait for each other: they
/// share the feed's two counters and nothing else. The reader and the mesher share a mutex, locked while a few pointers
/// change hands.
///
/// The chunks of one take() belong together: a reader that replaces older chunks by them, brick by brick, has the
/// closed mesh of one state of the mesher's replica after each take().
class MesherThread {
 public:
  /// Starts at once. The first take() with chunks gives the whole baked surface.
  /// @param phi0, feed  kept by reference, must outlive this. This thread is the feed's consumer.
  MesherThread(const BrickField& phi0, BrickFeed& feed, const MesherThreadOptions& options = {});
  /// For a piece: this thread makes its field first.   @param feed  the piece's feed from on_piece: shared with the
  /// maker of pieces as long as the piece may be in the scene.
  MesherThread(std::shared_ptr<const PieceOrigin> piece, std::shared_ptr<BrickFeed> feed,
               const MesherThreadOptions& options = {});
  /// Calls stop().
  ~MesherThread();
  MesherThread(const MesherThread&) = delete;
  MesherThread& operator=(const MesherThread&) = delete;

  /// Chunks that changed since the last take(), the newest of each brick, in order of brick; an empty chunk means that
  /// no surface is left there. One reader. O(changed chunks); waits for the mesher at most while it hands over
  /// pointers.
  std::vector<MeshChunkPtr> take();
  /// Edits meshed so far. Their lag behind the producer's successful pushes is the lag of the mesh.
  std::uint64_t editsDone() const noexcept { return edits_done_.load(std::memory_order_acquire); }

  /// Bricks that differ from phi0, after this thread has taken the whole feed. Any thread; waits for other callers and
  /// for the mesher: some ms, for a new piece until it is meshed.
  /// None: it has stopped.
  std::optional<BrickField> changedField();
  bool isPiece() const noexcept { return shared_feed_ != nullptr; }
  /// For a piece: its field when it came off; null until it is made, which is before the first changedField() returns.
  std::shared_ptr<const BrickField> pieceField() const;
  /// No other owner of the feed is left: the piece will not be seen again.
  bool isForgotten() const noexcept { return shared_feed_ && shared_feed_.use_count() == 1; }

  /// Meshes the current content of the feed and ends the thread; take() then gives the rest. May be called again.
  /// The producer should push no more: later bricks stay in the feed.
  void stop();

 private:
  void run(const BrickField& phi0);
  void publish(const std::vector<MeshChunkPtr>& chunks);
  bool isCopyWanted() const;
  void giveCopy(const BrickField& changed);

  std::shared_ptr<BrickFeed> shared_feed_;  // for a piece
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
  std::thread thread_;                                     // last: starts once all members above exist
};

}  // namespace kerf
