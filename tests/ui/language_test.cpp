#include "ui/app/base/language.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/script/command_palette.h"
#include "ui/app/settings/settings.h"

namespace kerf::language_test {
namespace {

namespace fs = std::filesystem;

const fs::path kGerman = fs::path(kSourceFolder) / "assets/languages/de.po";

std::string withHeader(const std::string& rows) {
  return "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\"X-Language-Name: Test\\n\"\n" +
         rows;
}
std::string row(const std::string& english, const std::string& translated) {
  return "msgid \"" + english + "\"\nmsgstr \"" + translated + "\"\n";
}

class LanguageTest : public testing::Test {
 protected:
  void TearDown() override { setShownLanguage(nullptr); }
  Language read(const std::string& rows) const {
    auto out = Language::read(folder_.write("test.po", withHeader(rows)));
    EXPECT_TRUE(out) << out.error().message();
    return out ? std::move(*out) : Language::marking();
  }
  void show(const std::string& rows) const { setShownLanguage(std::make_shared<const Language>(read(rows))); }
  std::string errorOf(const std::string& content) const {
    const auto out = Language::read(folder_.write("wrong.po", content));
    return out ? "" : out.error().message();
  }
  TemporaryFolder folder_;
};

TEST_F(LanguageTest, ATextIsLookedUpWholeAndStaysEnglishWhereTheFileHasNone) {
  const Language language =
      read(row("Cancel", "Abbrechen") + row("Quit", "") + "# a comment\n#, fuzzy\n" + row("Undo", "Redo") +
           "msgid \"\"\n\"say \\\"a\\\\b\\\"\\n\"\n\"and\\tgo\"\n" + "msgstr \"1\"\r\n\"2\"\n#~ msgid \"gone\"\n");
  EXPECT_EQ(language.name(), "Test");
  EXPECT_EQ(language.size(), 2u) << "empty and fuzzy texts count as untranslated";
  EXPECT_EQ(language.shown("Cancel"), "Abbrechen");
  EXPECT_EQ(language.shown("\n  Cancel "), "\n  Abbrechen ") << "blanks are of the layout";
  EXPECT_EQ(language.shown("say \"a\\b\"\nand\tgo"), "12");
  for (const char* const text : {"Quit", "Undo", "cancel", "1.25 / 3", " ", ""}) EXPECT_EQ(language.shown(text), text);
}

TEST_F(LanguageTest, APhraseHasItsValuesWhereTheTranslationHasThem) {
  show(row("Step {} of {}", "Von {1} Schritten: {0}") + row("about {:.1f} s left", "noch {:.1f} s") +
       row("Only {}", "Nur {}") + row("arch", "Zahnbogen"));
  EXPECT_EQ(phrase("Step {} of {}", 3, 14), "Von 14 Schritten: 3");
  EXPECT_EQ(phrase("  about {:.1f} s left", 2.25), "  noch 2.2 s");
  EXPECT_EQ(phrase("Only {}", "arch"), "Nur arch") << "a name stays";
  EXPECT_EQ(phrase("Only {}", shownText("arch")), "Nur Zahnbogen");
  EXPECT_EQ(phrase("{} more", 3), "3 more");
  setShownLanguage(nullptr);
  EXPECT_EQ(phrase("Only {}", "arch"), "Only arch");
}

TEST_F(LanguageTest, NumbersHaveTheDecimalSignOfTheLanguageAndNamesStay) {
  EXPECT_EQ(phrase("{:.2f} mm of {}", 1.5, "scan-2.5.stl"), "1.50 mm of scan-2.5.stl");
  show(row("{:.2f} mm of {}", "{1}: {0:.2f} mm"));
  EXPECT_EQ(phrase("{:.2f} mm of {}", 1.5, "scan-2.5.stl"), "scan-2.5.stl: 1.50 mm") << "a point without a header";

  ASSERT_TRUE(showLanguage("de", folder_.path()));
  EXPECT_EQ(shownDecimalSign(), ',');
  EXPECT_EQ(phrase("about {:.1f} m of {}", 2.25f, "scan-2.5.stl"), "about 2,2 m of scan-2.5.stl");
  EXPECT_EQ(shownNumbers("{:+7.1f} {:g} {:.{}f} {}", 1.25, 1e-7, 0.5, 2, 3), "   +1,2 1e-07 0,50 3");
  EXPECT_EQ(withDecimalSign("depth 0.25 mm..."), "depth 0,25 mm...");
  const std::string header = "msgid \"\"\nmsgstr \"charset=UTF-8\\nX-Language-Name: T\\nX-Decimal-Sign: ";
  EXPECT_NE(errorOf(header + ";\\n\"\n").find("a comma or a point"), std::string::npos);
}

TEST_F(LanguageTest, MarkedEachTextStandsInMarksOnce) {
  setShownLanguage(std::make_shared<const Language>(Language::marking()));
  EXPECT_EQ(shownText("Cancel"), "«Cancel»");
  EXPECT_EQ(shownText(phrase("Only {}", "arch")), "«Only arch»");
  EXPECT_EQ(shownText("1.25 / 3"), "1.25 / 3");
}

TEST_F(LanguageTest, AnIdIsThatOfTheEnglishLabelInEveryLanguage) {
  EXPECT_EQ(shownLabel("Cancel"), "Cancel###Cancel");
  show(row("Cancel", "Abbrechen"));
  EXPECT_EQ(shownLabel("Cancel"), "Abbrechen###Cancel");
  EXPECT_EQ(shownLabel("Cancel###job"), "Abbrechen###job");
  EXPECT_EQ(shownLabel("Cancel##job"), "Abbrechen###Cancel##job");
  EXPECT_EQ(shownLabel("##Cancel"), "##Cancel");
}

TEST_F(LanguageTest, AKeyIsTranslatedWholeOrInParts) {
  show(row("Ctrl", "Strg") + row("Ctrl+Home", "Strg+Pos1") + row("Home", "Eigener Ordner"));
  EXPECT_EQ(shownKey("Ctrl+Shift+P"), "Strg+Shift+P");
  EXPECT_EQ(shownKey("Ctrl+Home"), "Strg+Pos1");
  EXPECT_EQ(shownKey("+"), "+");
}

TEST_F(LanguageTest, AFileThatIsWrongIsRefusedWithItsLine) {
  struct Case {
    std::string rows;
    const char* says;
  };
  const Case cases[] = {{row("a {} b", "a b"), "{} or %"},
                        {row("a {} b", "a {} {} b"), "{} or %"},
                        {row("a {} b {}", "a {0} b {0}"), "{} or %"},
                        {row("a {} b {}", "a {0} b {}"), "{} or %"},
                        {row("a {:.1f} b", "a {:.2f} b"), "{} or %"},
                        {row("a b", "a {} b"), "{} or %"},
                        {row("a {} b", "a {1} b"), "{} or %"},
                        {row("a {x} b", "a {x} b"), "{} or %"},
                        {row("a { b", "a { b"), "{} or %"},
                        {row("push %.1f N", "%s"), "or % that"},
                        {row("push %.1f N", "Druck"), "or % that"},
                        {row("push", "% d"), "or % that"},
                        {row("a", "b##c"), "##"},
                        {row("fine", "gut"), "duplicate"},
                        {row(std::string(3000, 'a'), "b"), "2000"},
                        {"msgctxt \"menu\"\n" + row("a", "b"), "not supported"},
                        {"msgid_plural \"a\"\n", "not supported"},
                        {"msgstr \"a\"\n", "msgid"},
                        {"msgid \"a\\q\"\n", "quotes"},
                        {"msgid \"a\\\"\n", "quotes"},
                        {"msgid \"a\" b\n", "quotes"},
                        {std::string("msgid \"a\0b\"\n", 12), "quotes"}};
  for (const Case& one : cases) {
    const std::string error = errorOf(withHeader(row("fine", "gut") + one.rows));
    EXPECT_NE(error.find("wrong.po: line 7"), std::string::npos) << one.rows << error;
    EXPECT_NE(error.find(one.says), std::string::npos) << one.rows << error;
  }
  EXPECT_NE(errorOf(row("a", "b")).find("X-Language-Name"), std::string::npos);
  EXPECT_NE(errorOf(row("", "X-Language-Name: Test")).find("charset=UTF-8"), std::string::npos);
  EXPECT_NE(errorOf(std::string(Language::kMostBytes + 1, '#')).find("1 MiB"), std::string::npos);
  for (const fs::path& none : {folder_.path(), fs::path("/dev/zero"), folder_.path() / "none.po"})
    EXPECT_FALSE(Language::read(none)) << none;
}

// The reader reads or refuses damaged files. After a read, every lookup returns a text.
TEST_F(LanguageTest, BrokenFilesAndTextsNeverCrash) {
  std::ifstream in(kGerman);
  std::stringstream whole;
  whole << in.rdbuf();
  const std::string content = whole.str().substr(0, 6000), letters = "{}*%1#\"\\\n= aZ.-\xC3\xA4[]";
  std::mt19937 random(20261126);
  int read_files = 0;
  for (int n = 0; n < 300; ++n) {
    std::string broken = content;
    for (unsigned k = random() % 4; k > 0; --k) broken[random() % broken.size()] = letters[random() % letters.size()];
    broken.resize(broken.size() - random() % (broken.size() / 2));
    const auto language = Language::read(folder_.write("broken.po", broken));
    if (!language) continue;
    ++read_files;
    setShownLanguage(std::make_shared<const Language>(*language));
    EXPECT_NE(phrase("Step {} of {}", 3, 14).find("14"), std::string::npos);
    EXPECT_NE(shownText("push %.1f N").find("%.1f"), std::string::npos);
  }
  EXPECT_GE(read_files, 3) << "else nothing of it was tried";
}

TEST_F(LanguageTest, TheUsersFileGoesBeforeOursAndAWrongOneLeavesTheLanguageOfBefore) {
  fs::create_directories(folder_.path() / "languages");
  ASSERT_TRUE(showLanguage("de", folder_.path())) << "ours";
  EXPECT_EQ(shownText("Cancel"), "Abbrechen");
  folder_.write("languages/de.po", withHeader(row("Cancel", "Lassen")));
  folder_.write("languages/xx.po", "nothing");
  ASSERT_TRUE(showLanguage("de", folder_.path()));
  EXPECT_EQ(shownText("Cancel"), "Lassen");
  EXPECT_FALSE(showLanguage("xx", folder_.path()));
  EXPECT_FALSE(showLanguage("../languages/de", folder_.path()));
  EXPECT_EQ(shownText("Cancel"), "Lassen");
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

// Each command in a menu, each menu, and the steps of opening a scan.
TEST_F(LanguageTest, TheGermanFileHasAllCommandsAndTheStepsOfOpeningAScan) {
  const auto german = Language::read(kGerman);
  ASSERT_TRUE(german) << german.error().message();
  EXPECT_EQ(german->name(), "Deutsch");
  std::vector<std::string> texts{"closing",       "welding",           "point shell",   "looking for crossings",
                                 "filling holes", "building the base", "modelling pulp"};
  for (const AppCommand& command : appCommands())
    for (const std::string_view text : {menuOf(command), command.label}) texts.emplace_back(text);
  for (const std::string& text : texts) EXPECT_TRUE(text.empty() || german->shown(text) != text) << text;
}

}  // namespace
}  // namespace kerf::language_test
