#include "ui/window/gl/key_trickle.h"

#include <algorithm>
#include <set>
#include <utility>

namespace kerf {
namespace {

// GLFW's numbers, part of its interface.
constexpr int kFirstPrintable = 32, kLastPrintable = 162, kFirstModifier = 340, kLastModifier = 347;
constexpr int kShift = 1, kCapsLock = 16, kNumLock = 32;
constexpr int kRelease = 0, kPress = 1;

bool typesCharacter(const KeyTrickle::Event& e) {
  const bool has_command = (e.modifiers & ~(kShift | kCapsLock | kNumLock)) != 0;
  return e.key >= kFirstPrintable && e.key <= kLastPrintable && !has_command;
}

bool isModifier(const KeyTrickle::Event& e) { return e.key >= kFirstModifier && e.key <= kLastModifier; }

}  // namespace

std::vector<KeyTrickle::Event> KeyTrickle::takeFrame() {
  std::vector<Event> out;
  std::deque<Event> later;
  std::set<int> changed;
  bool is_full = false, has_key = false;
  for (const Event& e : waiting_) {
    const bool is_key = e.character == 0, is_change = is_key && (e.action == kPress || e.action == kRelease);
    const bool holds_up = !is_key || !typesCharacter(e);
    const bool is_key_alone = is_key && holds_up && e.action == kPress && !isModifier(e);

    bool fits = !(is_change && changed.count(e.key) > 0);
    if (holds_up) fits = fits && !is_full && !(has_key && (!is_key || is_key_alone));
    if (!fits) {
      is_full = is_full || holds_up;
      if (is_change) changed.insert(e.key);  // nor later changes of this key
      later.push_back(e);
      continue;
    }
    if (is_change) changed.insert(e.key);
    has_key = has_key || is_key_alone;
    out.push_back(e);
  }
  waiting_ = std::move(later);
  return out;
}

}  // namespace kerf
