// Keys and characters on their way to Dear ImGui, which knows of a frame only which keys are down in it: a tap within
// a slow frame would be lost, and what was typed before and after a key would be mixed up. No GLFW, no Dear ImGui.
#pragma once

#include <deque>
#include <vector>

namespace kerf {

class KeyTrickle {
 public:
  struct Event {
    int key = 0, scancode = 0, action = 0,
        modifiers = 0;       ///< as GLFW tells of a key: action 0 release, 1 press, 2 again
    unsigned character = 0;  ///< a code point in the place of a key; 0: a key
  };

  void add(const Event& event) { waiting_.push_back(event); }

  /// What one frame can take, in order; the rest waits for the next. No key changes twice in it, one key that is no
  /// character is pressed, and no character comes after that one. Keys that type a character hold nothing up: a word
  /// that is typed in a frame is there at once.
  std::vector<Event> takeFrame();
  /// Something waits for the next frame: it should come soon.
  bool isWaiting() const { return !waiting_.empty(); }

 private:
  std::deque<Event> waiting_;
};

}  // namespace kerf
