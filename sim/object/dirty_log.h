// What a subscriber to an object's changes has not been told yet.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/object/brick_feed.h"
#include "sim/object/brick_store.h"

namespace kerf {

/// Who is told of changed bricks: what draws the object, and what finds its pieces.
enum class BrickSubscriber : std::uint8_t { kMesher, kPieces };

/// The changed bricks of one subscriber, and the feed by which it is told of them. Both go where the object goes, into
/// undo and back.
struct DirtyLog {
  SlotList list;
  BrickFeed* feed = nullptr;
};

/// A DirtyLog together with the bricks it speaks of: a view, as good as the object it comes from.
class BrickChanges {
 public:
  BrickChanges(DirtyLog& log, BrickStore& bricks) : log_(log), bricks_(bricks) {}

  /// Bricks that wait to be taken. @rt
  std::size_t count() const noexcept { return log_.list.count(); }
  bool isEmpty() const noexcept { return log_.list.isEmpty(); }

  /// Gives the bricks changed since they were last taken: each once, with its newest values, the one that changed last
  /// first. Calls take(const BrickSlot&); false keeps that brick, and ends the call. @rt if take is.
  template <class Take>
  void take(const Take& take) const noexcept {
    log_.list.takeFromBack(bricks_.slots(), take);
  }

  /// Where the thread that cuts sends what changes; null: no one has subscribed.
  BrickFeed* feed() const noexcept { return log_.feed; }
  /// @param feed  is kept by pointer.
  void setFeed(BrickFeed* feed) const noexcept { log_.feed = feed; }

 private:
  DirtyLog& log_;
  BrickStore& bricks_;
};

}  // namespace kerf
