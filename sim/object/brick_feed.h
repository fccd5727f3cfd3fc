// Bricks from the thread that cuts to a subscriber (mesher, finder of pieces): a bounded queue without locks.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <vector>

#include "sim/object/brick_edit.h"

namespace kerf {

/// Ring of BrickEdits for one producer and one consumer; neither waits for the other.
///
/// Contract, so that nothing is ever lost:
/// - a push that returns false has changed nothing. The producer keeps that brick marked as pending and pushes its
///   values again in a later tick: the values it has then, since only the newest matter.
/// - edits arrive in the order of the pushes, and a later edit of a brick replaces an earlier one. Hence the consumer's
///   replica equals the producer's field as soon as nothing is pending and the feed is empty.
/// - in between the replica may hold bricks of different ticks. Each brick is whole: an edit is taken or not.
/// The consumer polls. Waking it would take a system call on the producer's side.
class BrickFeed {
 public:
  /// @param capacity  edits it can hold, rounded up to a power of two; 2 KiB each, allocated here and nowhere else.
  ///   Too small: the producer pushes the same bricks again and again, and the mesh lags behind the cut. A drill
  ///   changes 10 to 60 bricks a tick, so 1024 bridge at least 17 ms.
  explicit BrickFeed(std::size_t capacity = 1024)
      : ring_(std::bit_ceil(capacity < 1 ? std::size_t{1} : capacity)), mask_(ring_.size() - 1) {}
  BrickFeed(const BrickFeed&) = delete;
  BrickFeed& operator=(const BrickFeed&) = delete;

  std::size_t capacity() const noexcept { return ring_.size(); }

  /// Producer's thread only. False: full, and nothing has changed.
  /// @rt  safe: copies 2 KiB, no allocation, lock or system call.
  [[nodiscard]] bool tryPush(const Vec3i& brick, const BrickValues& phi) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - seen_head_ == ring_.size()) {  // full as far as was known: read again
      seen_head_ = head_.load(std::memory_order_acquire);
      if (tail - seen_head_ == ring_.size()) return false;
    }
    BrickEdit& slot = ring_[tail & mask_];
    slot.brick = brick;
    slot.phi = phi;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer's thread only. False: empty.
  [[nodiscard]] bool tryPop(BrickEdit& out) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    out = ring_[head & mask_];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Consumer's thread only: appends what is there now, at most a whole ring. Returns how many.
  std::size_t drain(std::vector<BrickEdit>& out) {
    const std::size_t head = head_.load(std::memory_order_relaxed), tail = tail_.load(std::memory_order_acquire);
    for (std::size_t n = head; n != tail; ++n) {
      out.push_back(ring_[n & mask_]);
      head_.store(n + 1, std::memory_order_release);  // one by one: the producer may use the slot at once
    }
    return tail - head;
  }

 private:
  std::vector<BrickEdit> ring_;
  std::size_t mask_;
  // Each side writes its own cache line: counters that never wrap in practice, taken modulo the size.
  alignas(64) std::atomic<std::size_t> tail_{0};  // written by the producer
  std::size_t seen_head_ = 0;                     // producer's copy, so that it reads the other line only when needed
  alignas(64) std::atomic<std::size_t> head_{0};  // written by the consumer
};

}  // namespace kerf
