// Queues keys and characters for Dear ImGui, which only sees the keys that are down in a frame: it would lose a tap
// within a slow frame, and mix up text typed before and after a key. No GLFW, no Dear ImGui.
#pragma once

#include <deque>
#include <vector>

namespace kerf {

class KeyTrickle {
 public:
  struct Event {
    int key = 0, scancode = 0, action = 0,
        modifiers = 0;       ///< GLFW's action: 0 release, 1 press, 2 repeat
    unsigned character = 0;  ///< code point instead of a key; 0: a key
  };

  void add(const Event& event) { waiting_.push_back(event); }

  /// Events that fit one frame, in order; the rest waits for the next. Within a frame no key changes twice, at most one
  /// key that is no character is pressed, and no character follows it. Keys that type a character do not delay: a word
  /// typed in a frame arrives at once.
  std::vector<Event> takeFrame();
  /// Events wait for the next frame, which should come soon.
  bool isWaiting() const { return !waiting_.empty(); }

 private:
  std::deque<Event> waiting_;
};

}  // namespace kerf
