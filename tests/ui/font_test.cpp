#include "ui/window/gl/font.h"

#include <gtest/gtest.h>

#include <string>

namespace kerf::font_test {
namespace {

// Letters in names of patients and files. A missing character would appear as a box or "?".
TEST(Font, WhatPeopleWriteInTheListedScriptsCanBeDrawn) {
  ImFontAtlas atlas;
  if (!addFont(atlas, 15)) GTEST_SKIP() << "WARNING: neither Inter nor DejaVu is installed (Debian: fonts-inter)";
  ASSERT_TRUE(atlas.Build());
  const ImFont& font = *atlas.Fonts[0];

  struct Script {
    const char* name;
    std::u16string letters;
  };
  const Script scripts[] = {
      {"Latin", u"AZaz09ÄÖÜäöüßéèçñåøæłŁşğİıőűčžđțăŵŷ"},
      {"Greek", u"ΑΒΓΔΩαβγδεθλμπσςωάέήίόύώ"},
      {"Cyrillic", u"АБВЯабвяёЁїЇєЄґҐўЎјљњћџ"},
      {"Vietnamese", u"ẠạẢảẤấẾếỆệỐốỘộỨứỰựỳỹ"},
      {"punctuation", u"–—‘’“”„…•"},
      {"currencies", u"€"},
      {"arrows and the minus", u"←↑→↓−"},
  };
  for (const Script& script : scripts)
    for (const char16_t letter : script.letters)
      EXPECT_NE(font.FindGlyphNoFallback(static_cast<ImWchar>(letter)), nullptr)
          << script.name << " U+" << std::hex << static_cast<int>(letter);
}

}  // namespace
}  // namespace kerf::font_test
