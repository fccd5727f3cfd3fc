#include "ui/app/language.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "tests/support/temporary_folder.h"
#include "ui/app/app_commands.h"
#include "ui/app/command_palette.h"
#include "ui/app/settings.h"

namespace kerf::language_test {
namespace {

namespace fs = std::filesystem;

class LanguageTest : public testing::Test {
 protected:
  void TearDown() override { setShownLanguage(nullptr); }
  static std::string withHeader(const std::string& texts) {
    return "format = \"kerf-language\"\nversion = 1\nname = \"Test\"\n[texts]\n" + texts;
  }
  Language read(const std::string& texts) const {
    auto out = Language::read(folder_.write("test.toml", withHeader(texts)));
    EXPECT_TRUE(out) << out.error().message();
    return out ? std::move(*out) : Language::marking();
  }
  std::string errorOf(const std::string& content) const {
    const auto out = Language::read(folder_.write("wrong.toml", content));
    return out ? "" : out.error().message();
  }
  TemporaryFolder folder_;
};

TEST_F(LanguageTest, ATextIsLookedUpWholeAndStaysEnglishWhereTheFileHasNone) {
  const Language language = read("\"Cancel\" = \"Abbrechen\"\n\"Quit\" = \"\"\n");
  EXPECT_EQ(language.name(), "Test");
  EXPECT_EQ(language.size(), 1u) << "\"\" is not translated yet";
  EXPECT_EQ(language.shown("Cancel"), "Abbrechen");
  EXPECT_EQ(language.shown("  Cancel "), "  Abbrechen ") << "blanks are of the layout";
  EXPECT_EQ(language.shown("Quit"), "Quit");
  EXPECT_EQ(language.shown("cancel"), "cancel");
  EXPECT_EQ(language.shown("1.25 / 3"), "1.25 / 3");
  EXPECT_EQ(language.shown(""), "");
}

TEST_F(LanguageTest, NumbersStandWhereThePlaceholdersAre) {
  const Language language = read(
      "\"about {} s left\" = \"noch etwa {} s\"\n\"Step {} of {}\" = \"Von {2} Schritten: {1}\"\n"
      "\"{} mm3 removed\" = \"{} mm3 entfernt\"\n\"Last 20 s\" = \"Letzte 20 s\"\n");
  EXPECT_EQ(language.shown("about 12 s left"), "noch etwa 12 s");
  EXPECT_EQ(language.shown("about 0.5 s left"), "noch etwa 0.5 s");
  EXPECT_EQ(language.shown("about two s left"), "about two s left");
  EXPECT_EQ(language.shown("Step 3 of 14"), "Von 14 Schritten: 3");
  EXPECT_EQ(language.shown("-1.50 mm3 removed"), "-1.50 mm3 entfernt") << "the 3 of mm3 is no number";
  EXPECT_EQ(language.shown("Last 20 s"), "Letzte 20 s");
  EXPECT_EQ(language.shown("about 12 s left, or more"), "about 12 s left, or more");
}

TEST_F(LanguageTest, WordsStandWhereTheStarsAreAndAreTranslatedThemselves) {
  const Language language = read(
      "\"Goes through the {*}\" = \"Geht durch: {*}\"\n\"nerve canal\" = \"Nervkanal\"\n\"Ctrl+{*}\" = \"Strg+{*}\"\n"
      "\"Shift+{*}\" = \"Umschalt+{*}\"\n\"{*}: {*}, at {} s\" = \"{1}: {2}, bei {3} s\"\n\"stroke\" = \"Strich\"\n"
      "\"Only {*}\" = \"Nur {*}\"\n\"Only {*} of {}\" = \"Nur {*} von {}\"\n");
  EXPECT_EQ(language.shown("Goes through the nerve canal"), "Geht durch: Nervkanal");
  EXPECT_EQ(language.shown("Goes through the sinus"), "Geht durch: sinus");
  EXPECT_EQ(language.shown("Goes through the "), "Goes through the ") << "no words: another text";
  EXPECT_EQ(language.shown("Ctrl+Shift+P"), "Strg+Umschalt+P");
  EXPECT_EQ(language.shown("4: stroke, at 1.5 s"), "4: Strich, bei 1.5 s");
  EXPECT_EQ(language.shown("Only tooth of gold of 3"), "Nur tooth of gold von 3") << "the more telling one goes first";
  EXPECT_EQ(language.shown("Only one\nOnly two"), "Nur one\nNur two") << "line by line";
}

TEST_F(LanguageTest, ANameStaysAsItIs) {
  const Language language = read(
      "\"arch\" = \"Zahnbogen\"\n\"Only {name}\" = \"Nur {name}\"\n\"{name}: {*}, {} s\" = \"{2}, {3} s: {1}\"\n"
      "\"Made of {*}\" = \"Aus {*}\"\n\"{name} and {} more\" = \"{name} und {} weitere\"\n");
  EXPECT_EQ(language.shown("Only arch"), "Nur arch");
  EXPECT_EQ(language.shown("Only Only arch"), "Nur Only arch");
  EXPECT_EQ(language.shown("Made of arch"), "Aus Zahnbogen");
  EXPECT_EQ(language.shown("arch: arch, 3 s"), "Zahnbogen, 3 s: arch");
  EXPECT_EQ(language.shown("arch and 2 more"), "arch und 2 weitere");
  EXPECT_EQ(language.shown("Only "), "Only ");
  EXPECT_NE(errorOf(withHeader("\"Only {name}\" = \"Nur {*}\"\n")).find("not the placeholders"), std::string::npos);
}

// The user's names are called as words that the file has.
TEST_F(LanguageTest, TheGermanFileLeavesNamesAndHasTheStepsOfOpeningAScan) {
  const auto german = Language::read(fs::path(KERF_SOURCE_DIR) / "assets/languages/de.toml");
  ASSERT_TRUE(german) << german.error().message();
  for (const char* const text :
       {"Import arch", "Sawing arch", "Only arch", "Beside: arch", "To arch", "Cut off arch", "exporting arch",
        "preparing arch", "opening arch", "reading arch", "arch: there already, would be replaced",
        "you have cut the neighbour arch: 0.2 mm3. Undo takes it back",
        "arch: cut 99 % of the planned section (12 mm2) in 8 s; 3.2 mm3 planned, 3.1 mm3 removed"}) {
    const std::string shown = german->shown(text);
    EXPECT_NE(shown, text);
    EXPECT_NE(shown.find("arch"), shown.npos) << shown;
  }
  for (const char* const text :
       {"closing", "welding", "point shell", "materials", "looking for crossings", "modelling enamel",
        "modelling caries", "building the base", "filling holes", "- C", "F", "O"})
    (void)german->shown(text);
  EXPECT_EQ(german->shown("modelling pulp"), "modelliert Pulpa");
  std::string missing;
  for (const std::string& text : german->missing()) missing += text + "\n";
  EXPECT_TRUE(missing.empty()) << missing;
}

TEST_F(LanguageTest, AnIdIsThatOfTheEnglishLabelInEveryLanguage) {
  EXPECT_EQ(shownLabel("Cancel"), "Cancel###Cancel");
  setShownLanguage(std::make_shared<const Language>(read("\"Cancel\" = \"Abbrechen\"\n")));
  EXPECT_EQ(shownLabel("Cancel"), "Abbrechen###Cancel");
  EXPECT_EQ(shownLabel("Cancel###job"), "Abbrechen###job");
  EXPECT_EQ(shownLabel("Cancel##job"), "Abbrechen###Cancel##job");
  EXPECT_EQ(shownLabel("##Cancel"), "##Cancel");
  EXPECT_EQ(shownText("Cancel"), "Abbrechen");
  setShownLanguage(nullptr);
  EXPECT_EQ(shownText("Cancel"), "Cancel");
}

// What a file says must never become a printf format with other conversions than there are values.
TEST_F(LanguageTest, AFormatKeepsItsConversions) {
  EXPECT_NE(errorOf(withHeader("\"push %.1f N\" = \"%s\"\n")).find("conversions"), std::string::npos);
  EXPECT_NE(errorOf(withHeader("\"push %.1f N\" = \"Druck\"\n")).find("%.1f"), std::string::npos);
  // Past the reader, by a placeholder.
  setShownLanguage(std::make_shared<const Language>(read(
      "\"push %.1f N\" = \"Druck %.1f N\"\n\"depth %.{*} mm\" = \"%n {*}\"\n\"{} % done\" = \"zu {} % fertig\"\n")));
  EXPECT_EQ(shownFormat("push %.1f N"), "Druck %.1f N");
  EXPECT_EQ(shownFormat("depth %.2f mm"), "depth %.2f mm");
  EXPECT_EQ(shownText("40 % done"), "zu 40 % fertig") << "a percent sign that is read";
}

TEST_F(LanguageTest, AFileThatIsWrongIsRefusedWithItsLine) {
  struct Case {
    const char* texts;
    const char* says;
  };
  const Case cases[] = {{"\"a {} b\" = \"a b\"\n", "not the placeholders"},
                        {"\"a {} b\" = \"a {} {} b\"\n", "not the placeholders"},
                        {"\"a {} b\" = \"a {*} b\"\n", "not the placeholders"},
                        {"\"a {} b {}\" = \"a {1} b {1}\"\n", "not the placeholders"},
                        {"\"a b\" = \"a {} b\"\n", "not the placeholders"},
                        {"\"a {} b\" = \"a {2} b\"\n", "{2}"},
                        {"\"a {x} b\" = \"a\"\n", "{x}"},
                        {"\"a { b\" = \"a\"\n", "{"},
                        {"\"a {name}\" = \"a\"\n", "not the placeholders"},
                        {"\"a {name}{*}\" = \"a {name}{*}\"\n", "nothing between"},
                        {"\"a } b\" = \"a\"\n", "a } alone"},
                        {"\"a {}{*}\" = \"a {}{*}\"\n", "nothing between"},
                        {"\"{}\" = \"{}\"\n", "placeholders alone"},
                        {"\"a\" = \"b##c\"\n", "##"},
                        {"\"a##c\" = \"b\"\n", "##"},
                        {"\"a\" = 3\n", "another type"},
                        {"\"a\" = \"b\\u0000c\"\n", "character 0"}};
  for (const Case& one : cases) {
    const std::string error = errorOf(withHeader("\"fine\" = \"gut\"\n" + std::string(one.texts)));
    EXPECT_NE(error.find("wrong.toml: line 6"), std::string::npos) << one.texts << error;
    EXPECT_NE(error.find(one.says), std::string::npos) << one.texts << error;
  }
  EXPECT_NE(errorOf("format = \"kerf-tool\"\nversion = 1\nname = \"x\"\n[texts]\n").find("kerf-language"),
            std::string::npos);
  EXPECT_NE(errorOf("format = \"kerf-language\"\nversion = 1\nname = \"x\"\n").find("[texts]"), std::string::npos);
  EXPECT_NE(errorOf("format = \"kerf-language\"\nversion = 1\nname = \"x\"\nfonts = 1\n[texts]\n").find("fonts"),
            std::string::npos);
  for (const char* const name : {"a\\u0000b", "a\\nb", "\\u007F"})
    EXPECT_NE(
        errorOf(fmt::format("format = \"kerf-language\"\nversion = 1\nname = \"{}\"\n[texts]\n", name)).find("control"),
        std::string::npos)
        << name;
  EXPECT_NE(errorOf(std::string(Language::kMostBytes + 1, '#')).find("1 MiB"), std::string::npos);
  EXPECT_NE(errorOf(withHeader("\"" + std::string(3000, 'a') + "\" = \"b\"\n")).find("2000"), std::string::npos);
  EXPECT_FALSE(Language::read(folder_.path()));
  EXPECT_FALSE(Language::read("/dev/zero"));
  EXPECT_FALSE(Language::read(folder_.path() / "none.toml"));
}

// Files out of order: refused or read, and then any text is answered.
TEST_F(LanguageTest, BrokenFilesAndTextsNeverCrash) {
  std::ifstream in(fs::path(KERF_SOURCE_DIR) / "assets/languages/de.toml");
  std::stringstream whole;
  whole << in.rdbuf();
  const std::string content = whole.str().substr(0, 6000);
  ASSERT_GT(content.size(), 1000u);
  std::mt19937 random(20261126);
  const std::string letters = "{}*%1#\"\\\n= aZ.-\xC3\xA4[]";
  int read_files = 0;
  for (int n = 0; n < 300; ++n) {
    std::string broken = content;
    for (unsigned k = random() % 4; k > 0; --k) broken[random() % broken.size()] = letters[random() % letters.size()];
    broken.resize(broken.size() - random() % (broken.size() / 2));
    const auto language = Language::read(folder_.write("broken.toml", broken));
    if (!language) continue;
    ++read_files;
    for (int k = 0; k < 20; ++k) {
      std::string text;
      for (unsigned c = random() % 60; c > 0; --c) text += letters[random() % letters.size()];
      (void)language->shown(text);
    }
  }
  EXPECT_GT(read_files, 5) << "else nothing of it was tried";

  // A star that fits at every character: no more work than characters times pieces.
  const Language slow = read("\"{*}a{*}a{*}a{*}a{*}a{*}a{*}a{*}b\" = \"{1}{2}{3}{4}{5}{6}{7}{8}\"\n");
  const std::string many(Language::kLongestText, 'a');
  EXPECT_EQ(slow.shown(many), many);
}

TEST_F(LanguageTest, WhatIsMissingIsWrittenForATranslator) {
  EXPECT_FALSE(writeMissingTexts(folder_.path() / "english.toml")) << "English misses nothing";
  setShownLanguage(std::make_shared<const Language>(read("\"Cancel\" = \"Abbrechen\"\n")));
  for (const char* const text : {"Cancel", "say \"hello\"", "about 3 s left", "about 4 s left", " Quit", "12"})
    (void)shownText(text);
  const fs::path file = folder_.path() / "missing.toml";
  const auto count = writeMissingTexts(file);
  ASSERT_TRUE(count) << count.error().message();
  EXPECT_EQ(*count, 3u) << "two times the same text but for its number";
  EXPECT_FALSE(writeMissingTexts(file)) << "a translation is not written over";

  std::ifstream in(file);
  std::stringstream content;
  content << in.rdbuf();
  EXPECT_NE(content.str().find("\"about {} s left\" = \"\""), std::string::npos) << content.str();
  EXPECT_NE(content.str().find("\"Quit\" = \"\""), std::string::npos) << content.str();
  const auto again = Language::read(file);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->size(), 0u);
}

// Names of files are any bytes; what the reader refuses as a key is not written for a translator.
TEST_F(LanguageTest, WhatCannotBeAKeyIsNotToldAsMissing) {
  setShownLanguage(std::make_shared<const Language>(read("\"Cancel\" = \"Abbrechen\"\n")));
  const std::string none[] = {"scan \xE4.stl",
                              "scan \xC3",
                              "\xED\xA0\x80 scan",
                              "\xC0\xAF scan",
                              "\xF5\x80\x80\x80 a",
                              "scan {1}.stl",
                              "open {",
                              "close }",
                              "all {*}",
                              "a##b",
                              std::string("a\0b", 3),
                              "F",
                              "O"};
  for (const std::string& text : none) EXPECT_EQ(shownText(text), text);
  const std::string some[] = {"scan \xC3\xA4.stl", "\xE2\x80\xA6 left", "\xF0\x9F\xA6\xB7 36", "F8", "a\tb \"c\""};
  for (const std::string& text : some) (void)shownText(text);
  const fs::path file = folder_.path() / "missing.toml";
  const auto count = writeMissingTexts(file);
  ASSERT_TRUE(count) << count.error().message();
  EXPECT_EQ(*count, std::size(some));

  // Translated, all of it is read.
  std::ifstream in(file);
  std::stringstream content;
  for (std::string line; std::getline(in, line);)
    content << (line.ends_with(" = \"\"") ? line.substr(0, line.size() - 2) + line.substr(0, line.size() - 5) : line)
            << '\n';
  const auto again = Language::read(folder_.write("again.toml", content.str()));
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->size(), std::size(some));
}

TEST_F(LanguageTest, TheUsersFileGoesBeforeOursAndAWrongOneLeavesTheLanguageOfBefore) {
  fs::create_directories(folder_.path() / "languages");
  ASSERT_TRUE(showLanguage("de", folder_.path())) << "ours";
  EXPECT_EQ(shownText("Cancel"), "Abbrechen");
  folder_.write("languages/de.toml", withHeader("\"Cancel\" = \"Lassen\"\n"));
  folder_.write("languages/xx.toml", "nothing");
  ASSERT_TRUE(showLanguage("de", folder_.path()));
  EXPECT_EQ(shownText("Cancel"), "Lassen");
  EXPECT_FALSE(showLanguage("xx", folder_.path()));
  EXPECT_FALSE(showLanguage("../languages/de", folder_.path()));
  EXPECT_EQ(shownText("Cancel"), "Lassen");
  ASSERT_TRUE(showLanguage("marked", folder_.path()));
  EXPECT_EQ(shownText("Cancel"), "«Cancel»");
  ASSERT_TRUE(showLanguage("en", folder_.path()));
  EXPECT_EQ(shownText("Cancel"), "Cancel");
}

TEST_F(LanguageTest, TheCommandKeepsItAndThePaletteFindsTheShownWords) {
  WorkbenchOptions options;
  options.data_folder = folder_.path() / "data";
  Workbench bench(options);
  Camera camera;
  SettingsFile settings(folder_.path() / "config");
  AppContext context{.bench = bench, .camera = camera, .settings = &settings};
  EXPECT_TRUE(findAppCommands("rückgängig").empty());
  ASSERT_TRUE(runAppCommand(context, "settings.language", std::vector<std::string>{"de"}));
  EXPECT_EQ(SettingsFile(folder_.path() / "config").values.language, "de");
  ASSERT_FALSE(findAppCommands("RÜCKGÄNGIG").empty());
  EXPECT_EQ(findAppCommands("RÜCKGÄNGIG")[0]->id, "edit.undo");
  EXPECT_EQ(findAppCommands("undo")[0]->id, "edit.undo") << "the English words, too";
  EXPECT_FALSE(runAppCommand(context, "settings.language", std::vector<std::string>{"tlh"}));
  EXPECT_EQ(settings.values.language, "de");
  EXPECT_EQ(shownText("Cancel"), "Abbrechen");
}

// Each command that a menu lists, and each menu.
TEST_F(LanguageTest, TheGermanFileHasAllCommands) {
  const auto german = Language::read(fs::path(KERF_SOURCE_DIR) / "assets/languages/de.toml");
  ASSERT_TRUE(german) << german.error().message();
  EXPECT_EQ(german->name(), "Deutsch");
  for (const AppCommand& command : appCommands())
    for (const std::string_view text : {command.menu, command.label}) (void)german->shown(text);
  std::string missing;
  for (const std::string& text : german->missing()) missing += text + "\n";
  EXPECT_TRUE(missing.empty()) << missing;
}

}  // namespace
}  // namespace kerf::language_test
