// A list with the links in its items: joined and moved in constant time, without memory of its own.
#pragma once

#include <cstddef>

namespace kerf {

/// Singly linked, through the items' `next`. Owns nothing, allocates nothing. All of it is O(1). @rt
template <class T>
struct LinkedList {
  T *first = nullptr, *last = nullptr;
  std::size_t count = 0;

  bool isEmpty() const noexcept { return count == 0; }

  void pushFront(T* item) noexcept {
    item->next = first;
    first = item;
    if (!last) last = item;
    ++count;
  }

  /// @pre not empty.
  T* popFront() noexcept {
    T* const item = first;
    first = item->next;
    if (!first) last = nullptr;
    item->next = nullptr;
    --count;
    return item;
  }

  /// Appends all of another list, and empties that one.
  void append(LinkedList& other) noexcept {
    if (other.isEmpty()) return;
    (last ? last->next : first) = other.first;
    last = other.last;
    count += other.count;
    other = {};
  }
};

}  // namespace kerf
