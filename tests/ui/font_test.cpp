#include "ui/window/font.h"

#include <gtest/gtest.h>

#include <string>

namespace kerf::font_test {
namespace {

// Letters as names of patients and files have them; a character that is missing would be drawn as a box or "?".
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

  // And each listed range has letters at all.
  const auto ranges = writtenCharacters();
  ASSERT_EQ(ranges.size() % 2, 0u);
  for (std::size_t n = 0; n < ranges.size(); n += 2) {
    int drawn = 0;
    for (int letter = ranges[n]; letter <= ranges[n + 1]; ++letter)
      drawn += font.FindGlyphNoFallback(static_cast<ImWchar>(letter)) != nullptr;
    EXPECT_GT(drawn, 0) << std::hex << ranges[n] << " to " << ranges[n + 1];
  }
}

}  // namespace
}  // namespace kerf::font_test
