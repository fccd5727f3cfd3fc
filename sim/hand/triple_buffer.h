// The newest value from one thread to another: neither ever waits, and newer values replace unread ones.
#pragma once

#include <array>
#include <atomic>

namespace kerf {

/// Three slots: one being written, one being read, and one in between that changes hands with a single exchange. One
/// writer, one reader; every call takes a bounded number of steps. @rt safe on both sides, as far as copying a T is.
///
/// The reader sees values in the order they were published, may miss some, and never sees half of one.
template <class T>
class TripleBuffer {
 public:
  TripleBuffer() = default;
  TripleBuffer(const TripleBuffer&) = delete;
  TripleBuffer& operator=(const TripleBuffer&) = delete;

  /// Writer: the slot to fill. Holds some older value, not the last one published.
  T& back() noexcept { return slot_[write_]; }
  /// Writer: publishes back().
  void publish() noexcept { write_ = middle_.exchange(write_ | kFresh, std::memory_order_acq_rel) & kIndex; }

  /// Reader: fetches the newest. False: nothing new since the last call, and front() is unchanged.
  bool update() noexcept {
    if (!(middle_.load(std::memory_order_relaxed) & kFresh)) return false;
    read_ = middle_.exchange(read_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  /// Reader: the value fetched last; a default one before the first.
  const T& front() const noexcept { return slot_[read_]; }

 private:
  static constexpr unsigned kIndex = 3, kFresh = 4;
  std::array<T, 3> slot_{};
  // Each side on a cache line of its own.
  alignas(64) std::atomic<unsigned> middle_{1};  // the slot in between, and whether it was published and not yet read
  alignas(64) unsigned write_ = 0;
  alignas(64) unsigned read_ = 2;
};

}  // namespace kerf
