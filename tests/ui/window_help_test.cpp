#include "ui/app/script/window_help.h"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/script/app_script.h"

namespace kerf::window_help_test {
namespace {

TEST(WindowHelp, EachCommandOfTheWindowStandsOnceWithItsParametersKeyAndSentence) {
  const std::vector<HelpPage> pages = windowHelp();
  for (const AppCommand& command : appCommands()) {
    const std::vector<const HelpEntry*> entries = findEntries(pages, std::string(command.id));
    ASSERT_EQ(entries.size(), 1u) << command.id;
    EXPECT_TRUE(entries[0]->term.ends_with(command.parameters)) << command.id;
    EXPECT_NE(entries[0]->note.find(command.key), std::string::npos) << command.id;
    EXPECT_EQ(entries[0]->text, command.description);
  }
}

TEST(WindowHelp, EachMenuHasASectionWithItsCommands) {
  const std::vector<HelpPage> pages = windowHelp();
  for (const AppCommand& command : appCommands()) {
    if (command.menu.empty()) continue;
    bool is_in_its_menu = false;
    for (const HelpSection& section : pages[0].sections)
      for (const HelpEntry& entry : section.entries)
        is_in_its_menu |= section.title == "Menu " + std::string(menuOf(command)) && nameOf(entry) == command.id;
    EXPECT_TRUE(is_in_its_menu) << command.id;
  }
}

TEST(WindowHelp, NamesEachValueThatExpectTakes) {
  const TemporaryFolder folder;
  WorkbenchOptions options;
  options.data_folder = folder.path();
  Workbench bench(options);
  Camera camera;
  AppContext context{.bench = bench, .camera = camera};
  const auto run = runScript(context, folder.write("script.ks", "expect nothing 0 1\n"), [] {});
  ASSERT_FALSE(run);

  const std::vector<HelpPage> pages = windowHelp();
  std::string values = run.error().expected;  // "removed, depth, ..., device or device-force"
  for (std::size_t at = 0; (at = values.find(" or ", at)) != values.npos;) values.replace(at, 4, ", ");
  std::istringstream names(values);
  std::size_t count = 0;
  for (std::string name; std::getline(names >> std::ws, name, ','); ++count)
    EXPECT_EQ(findEntries(pages, name).size(), 1u) << name;
  EXPECT_GE(count, 20u) << values;
}

TEST(HelpPage, LinesHaveAtMost80CharactersExceptLongTerms) {
  for (const HelpPage& page : windowHelp()) {
    std::istringstream lines(plainText(page));
    for (std::string line; std::getline(lines, line);)
      if (!line.starts_with("  ") || line.starts_with("      ")) {
        EXPECT_LE(line.size(), 80u) << line;
      }
  }
}

TEST(HelpPage, AnEntryHasItsKeyBesideItAndItsTextBelow) {
  EXPECT_EQ(plainText(HelpEntry{"view.roll [DEG]", "R", "Turns the picture."}),
            "  view.roll [DEG]                               R\n      Turns the picture.\n");
  EXPECT_EQ(plainText(HelpEntry{"wait", "", "Waits."}), "  wait\n      Waits.\n");
}

}  // namespace
}  // namespace kerf::window_help_test
