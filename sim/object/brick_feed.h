// Bricks from the cutting thread to a subscriber (mesher, piece finder): a bounded queue without locks.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <vector>

#include "sim/object/brick_edit.h"

namespace kerf {

/// Ring of BrickEdits for one producer and one consumer; neither waits for the other.
///
/// Contract, so that no edit is lost:
/// - A push that returns false changes nothing. The producer keeps the brick marked as pending and pushes its newest
///   values in a later tick.
/// - Edits arrive in the order of the pushes, and a later edit of a brick replaces an earlier one. The consumer's
///   replica equals the producer's field once nothing is pending and the feed is empty.
/// - Until then the replica can hold bricks of different ticks. Each brick is whole.
/// The consumer polls. Waking it would take a system call on the producer's side.
class BrickFeed {
 public:
  /// @param capacity  edits it can hold, rounded up to a power of two; 2 KiB each, allocated here only. If it is too
  ///   small, the producer pushes the same bricks repeatedly, and the mesh lags behind the cut. A drill changes 10 to
  ///   60 bricks a tick, so 1024 bridge at least 17 ms.
  explicit BrickFeed(std::size_t capacity = 1024)
      : ring_(std::bit_ceil(capacity < 1 ? std::size_t{1} : capacity)), mask_(ring_.size() - 1) {}
  BrickFeed(const BrickFeed&) = delete;
  BrickFeed& operator=(const BrickFeed&) = delete;

  std::size_t capacity() const noexcept { return ring_.size(); }

  /// Producer's thread only. False: the ring is full, and nothing has changed.
  /// @rt  safe: copies 2 KiB, no allocation, lock or system call.
  [[nodiscard]] bool tryPush(const Vec3i& brick, const BrickValues& phi) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - seen_head_ == ring_.size()) {  // seems full: read the head again
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

  /// Consumer's thread only: appends all waiting edits, at most a whole ring. Returns their number.
  std::size_t drain(std::vector<BrickEdit>& out) {
    const std::size_t head = head_.load(std::memory_order_relaxed), tail = tail_.load(std::memory_order_acquire);
    for (std::size_t n = head; n != tail; ++n) {
      out.push_back(ring_[n & mask_]);
      head_.store(n + 1, std::memory_order_release);  // one by one: frees each slot at once for the producer
    }
    return tail - head;
  }

 private:
  std::vector<BrickEdit> ring_;
  std::size_t mask_;
  // Each side writes its own cache line. The counters never wrap in practice; the index is the counter modulo the size.
  alignas(64) std::atomic<std::size_t> tail_{0};  // written by the producer
  std::size_t seen_head_ = 0;                     // producer's copy: avoids reading the other line
  alignas(64) std::atomic<std::size_t> head_{0};  // written by the consumer
};

}  // namespace kerf
