#include "ui/window/gl/key_names.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace kerf {

KeyChord keyChord(std::string_view name) {
  KeyChord out;
  const auto take = [&](std::string_view prefix, int modifier) {
    if (!name.starts_with(prefix)) return;
    out.modifiers |= modifier;
    name.remove_prefix(prefix.size());
  };
  take("Ctrl+", GLFW_MOD_CONTROL);
  take("Shift+", GLFW_MOD_SHIFT);
  take("Alt+", GLFW_MOD_ALT);

  // For printable keys GLFW's number is the character, in capitals.
  if (name.size() == 1)
    out.key = name[0];
  else if (name.size() == 2 && name[0] == 'F' && name[1] >= '1' && name[1] <= '9')
    out.key = GLFW_KEY_F1 + (name[1] - '1');
  else if (name == "Esc")
    out.key = GLFW_KEY_ESCAPE;
  else if (name == "Enter")
    out.key = GLFW_KEY_ENTER;
  else if (name == "PageUp")
    out.key = GLFW_KEY_PAGE_UP;
  else if (name == "PageDown")
    out.key = GLFW_KEY_PAGE_DOWN;
  else if (name == "Space")
    out.key = GLFW_KEY_SPACE;
  else if (name == "Home")
    out.key = GLFW_KEY_HOME;
  else if (name == "End")
    out.key = GLFW_KEY_END;
  else if (name == "Tab")
    out.key = GLFW_KEY_TAB;
  else if (name == "Delete")
    out.key = GLFW_KEY_DELETE;
  return out;
}

}  // namespace kerf
