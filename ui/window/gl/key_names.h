// Names of keys in the form of the command table: "Ctrl+Z", "F", "]".
#pragma once

#include <string_view>

namespace kerf {

/// A GLFW key with its modifiers (GLFW_MOD_...). key 0: no such name.
struct KeyChord {
  int key = 0, modifiers = 0;
  bool operator==(const KeyChord&) const = default;
};
KeyChord keyChord(std::string_view name);

}  // namespace kerf
