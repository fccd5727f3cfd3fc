// Changes of an object that a subscriber has not received yet.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/object/brick_feed.h"
#include "sim/object/brick_store.h"

namespace kerf {

/// Subscribers to changed bricks: the mesher draws the object, the piece finder finds its pieces.
enum class BrickSubscriber : std::uint8_t { kMesher, kPieces };

/// The changed bricks of one subscriber, and its feed. Both stay with the object through undo and redo.
struct DirtyLog {
  SlotList list;
  BrickFeed* feed = nullptr;
};

/// A DirtyLog together with its bricks: a view, valid as long as its object.
class BrickChanges {
 public:
  BrickChanges(DirtyLog& log, BrickStore& bricks) : log_(log), bricks_(bricks) {}

  /// Number of waiting bricks. @rt
  std::size_t count() const noexcept { return log_.list.count(); }
  bool isEmpty() const noexcept { return log_.list.isEmpty(); }

  /// Gives the bricks changed since the last call: each once, with its newest values, the last changed first. Calls
  /// take(const BrickSlot&); false keeps that brick and ends the call. @rt if take is.
  template <class Take>
  void take(const Take& take) const noexcept {
    log_.list.takeFromBack(bricks_.slots(), take);
  }

  /// Where the cutting thread sends changes; null: no subscriber.
  BrickFeed* feed() const noexcept { return log_.feed; }
  /// @param feed  kept by pointer.
  void setFeed(BrickFeed* feed) const noexcept { log_.feed = feed; }

 private:
  DirtyLog& log_;
  BrickStore& bricks_;
};

}  // namespace kerf
