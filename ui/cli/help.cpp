// kerf help: the text of --help, and the topics of help_page.h.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "geometry/base/text.h"
#include "geometry/base/toml_reader.h"
#include "ui/app/program/help_page.h"
#include "ui/app/script/window_help.h"
#include "ui/cli/command.h"
#include "ui/cli/commands.h"

namespace kerf::cli {
namespace {

// Null if the command has no command of that name.
const CLI::App* commandOf(const CLI::App& app, const std::string& name) {
  const std::vector<const CLI::App*> found =
      app.get_subcommands([&](const CLI::App* command) { return command->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

std::vector<std::string> commandNames(const CLI::App& app) {
  std::vector<std::string> out;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App* c) { return !c->get_name().empty(); }))
    out.push_back(command->get_name());
  return out;
}

// Topics of one word: commands of kerf, pages, entries of the pages.
std::vector<std::string> topicNames(const CLI::App& program, const std::vector<HelpPage>& pages) {
  std::vector<std::string> out = commandNames(program);
  for (const HelpPage& page : pages) {
    out.push_back(page.name);
    for (const HelpSection& section : page.sections)
      for (const HelpEntry& entry : section.entries) out.push_back(nameOf(entry));
  }
  return out;
}

// "no topic "bke" (did you mean bake?)"
int complainOfTopic(std::string found, const std::string& word, std::vector<std::string> known,
                    const std::string& hint) {
  std::string near;
  for (const std::string& name : nearestNames(word, std::move(known), 3)) near += (near.empty() ? "" : ", ") + name;
  if (!near.empty()) found += fmt::format(" (did you mean {}?)", near);
  return complainOfUsage({.code = Error::Code::kBadValue, .found = std::move(found), .hint = hint});
}

// True if the word is a page or names entries of pages.
bool printTopic(const std::vector<HelpPage>& pages, const std::string& word) {
  for (const HelpPage& page : pages) {
    if (page.name != word) continue;
    printText("{}", plainText(page));
    return true;
  }

  const std::vector<const HelpEntry*> entries = findEntries(pages, word);
  for (const HelpEntry* entry : entries) printText("{}", plainText(*entry));
  return !entries.empty();
}

int runHelp(const CLI::App& program, const std::vector<std::string>& topic) {
  const CLI::App* app = &program;
  std::string parents, typed = program.get_name();
  for (const std::string& word : topic) {
    const CLI::App* const next = commandOf(*app, word);
    if (!next && app == &program) {
      const std::vector<HelpPage> pages = windowHelp();
      if (topic.size() == 1 && printTopic(pages, word)) return kOk;
      return complainOfTopic(fmt::format("no help topic \"{}\"", fmt::join(topic, " ")), word,
                             topicNames(program, pages), "kerf help");
    }
    if (!next)
      return complainOfTopic(fmt::format("{} has no command \"{}\"", typed, word), word, commandNames(*app),
                             "kerf help" + typed.substr(program.get_name().size()));
    app = next;
    parents = typed;
    typed += " " + word;
  }
  // help() of the program would print the help of its parsed command, which is this one.
  const bool is_program = app == &program;
  printText("{}",
            is_program ? app->get_formatter()->make_help(app, typed, CLI::AppFormatMode::Normal) : app->help(parents));
  return kOk;
}

}  // namespace

void addHelp(CLI::App& command, int& exit_code) {
  auto topic = std::make_shared<std::vector<std::string>>();
  command.footer(
      "Examples:\n"
      "  kerf help tool check\n"
      "  kerf help window\n"
      "  kerf help view.roll");
  command.add_option("TOPIC", *topic, "a command, one of the topics of kerf help, or a command of the window");
  command.callback([&command, topic, &exit_code] { exit_code = runHelp(*command.get_parent(), *topic); });
}

}  // namespace kerf::cli
