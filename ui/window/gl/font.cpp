#include "ui/window/gl/font.h"

#include <filesystem>
#include <system_error>

namespace kerf {
namespace {

// First and last of each range: Latin with its extensions, Greek, Cyrillic, punctuation, currencies, arrows, the minus.
// Users choose the names of files and pieces. Ended by 0 for Dear ImGui.
constexpr ImWchar kScripts[] = {0x0020, 0x024F, 0x02B0, 0x03FF, 0x0400, 0x052F, 0x1E00, 0x1EFF, 0x2010,
                                0x205E, 0x20A0, 0x20BF, 0x2190, 0x2193, 0x2212, 0x2212, 0};

}  // namespace

bool addFont(ImFontAtlas& atlas, float pixels) {
  std::error_code ignored;
  for (const char* const font :
       {"/usr/share/fonts/opentype/inter/Inter-Regular.otf", "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"})
    if (std::filesystem::exists(font, ignored) && atlas.AddFontFromFileTTF(font, pixels, nullptr, kScripts))
      return true;
  return false;
}

}  // namespace kerf
