#include "ui/app/commands/command_tables.h"

#include <optional>
#include <string>

#include "ui/app/base/command_words.h"
#include "ui/app/settings/settings.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/scene_neighbours.h"

namespace kerf::export_commands {
namespace {

// Choice from the words of `export.pieces`. None: unknown words.
std::optional<ExportChoice> choiceOf(const AppContext& c, AppWords words) {
  const std::string what = words.empty() ? "" : words[0], name = words.size() > 1 ? words[1] : "";
  if (what == "all") return ExportChoice{};
  if (what == "put-back") return ExportChoice{.is_put_back = true};
  if (what == "each") return ExportChoice{.is_each = true};
  if (what == "beside") {
    const SceneObject* const object = c.bench.neighbours->find(name);
    return object ? std::optional(ExportChoice{.beside = object->loaded}) : std::nullopt;
  }
  if (what != "piece") return {};
  const auto shown = c.bench.document->scene().shown();
  for (std::size_t n = 0; n < shown.size(); ++n)
    if (!shown[n]->isBeside() && (shown[n]->name == name || std::to_string(n + 1) == name))
      return ExportChoice{.only = shown[n]->id};
  return {};
}

bool isShown(const AppContext& c) { return c.bench.exporting->isShown(); }
bool canShow(const AppContext& c) {
  return isShown(c) || (c.bench.document->isOpen() && !c.bench.imports->isImporting() && !c.bench.jobs->running());
}
bool isWritten(const AppContext& c) { return c.bench.exporting->written().has_value(); }

Expected<void> show(AppContext& c, AppWords words) {
  ExportPlan& plan = *c.bench.exporting;
  if (!words.empty() && words[0] != "on" && words[0] != "off") return wrongWord("\"" + words[0] + "\"", "on or off");
  const bool is_wanted = words.empty() ? !plan.isShown() : words[0] == "on";
  if (!is_wanted)
    plan.hide();
  else if (!plan.isShown())
    plan.show(c.settings ? c.settings->values.last_folder : std::filesystem::path());
  return {};
}

Expected<void> choose(AppContext& c, AppWords words) {
  ExportPlan& plan = *c.bench.exporting;
  const auto choice = choiceOf(c, words);
  std::string offered;
  for (const ExportOffer& offer : plan.offers()) {
    offered += (offered.empty() ? "" : "; ") + offer.label;
    if (!choice || offer.choice != *choice) continue;
    plan.choose(*choice);
    return {};
  }
  std::string said;
  for (const std::string& word : words) said += (said.empty() ? "" : " ") + word;
  return wrongWord("\"" + said + "\"", "all, each, put-back, piece NAME or beside NAME, of what there is: " + offered);
}

Expected<void> format(AppContext& c, AppWords words) {
  return c.bench.exporting->setFormat(words.empty() ? std::string() : words[0]);
}

Expected<void> to(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  return c.bench.exporting->setFile(path);
}

Expected<void> check(AppContext& c, AppWords) {
  c.bench.exporting->check();
  return {};
}

Expected<void> write(AppContext& c, AppWords words) {
  ExportPlan::Permission permission;
  for (const std::string& word : words) {
    if (word != "replace" && word != "anyway") return wrongWord("\"" + word + "\"", "replace, anyway, or nothing");
    (word == "replace" ? permission.may_replace : permission.may_be_doubtful) = true;
  }
  ExportPlan& plan = *c.bench.exporting;
  plan.write(permission);
  if (!plan.asksToReplace()) return {};
  return fail({.code = Error::Code::kBadValue,
               .file = plan.replaced().front().string(),
               .found = "a file that is there already",
               .expected = "another name",
               .hint = "export.write replace, or export.to"});
}

Expected<void> showInFolder(AppContext& c, AppWords) { return c.bench.exporting->showInFolder(); }

constexpr AppCommand kRows[] = {
    {"export.show", "File:3", "Export...", "Ctrl+E", "[on|off]",
     "Shows what is exported, in which format and where to, and checks it; or puts that away.", canShow, show},
    {"export.pieces", "", "", "", "WHICH [NAME]",
     "Chooses what is exported: all in one file, each piece in a file of its own, put-back, piece NAME, beside NAME.",
     isShown, choose},
    {"export.format", "", "", "", "FORMAT",
     "Chooses the format of the file by its name: stl, 3mf or another that is written.", isShown, format},
    {"export.to", "", "", "", "PATH", "Chooses the file that is written; its ending is the format.", isShown, to},
    {"export.check", "", "", "", "", "Checks again what would be exported, without writing it.", isShown, check},
    {"export.write", "", "", "", "[replace] [anyway]",
     "Writes the file, reads it back and checks it; replace: one that is there already; anyway: also what is not ready "
     "to print.",
     isShown, write},
    {"export.show-in-folder", "File:3", "Show what was exported in its folder", "", "",
     "Shows what was exported last in the file manager of the desktop.", isWritten, showInFolder},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::export_commands
