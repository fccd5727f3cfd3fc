#include "ui/app/commands/command_tables.h"

#include <optional>
#include <string>

#include "ui/app/base/command_words.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/settings/settings.h"
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
      return ExportChoice{.only = {shown[n]->id}};
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
  return wrongWord("\"" + said + "\"", "all, each, put-back, piece NAME or beside NAME; available: " + offered);
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
               .found = "an existing file",
               .expected = "another name",
               .hint = "export.write replace, or export.to"});
}

Expected<void> showInFolder(AppContext& c, AppWords) { return c.bench.exporting->showInFolder(); }

constexpr AppCommand kRows[] = {
    {"export.show", "File:3", "Export...", "Ctrl+E", "[on|off]",
     "Shows or hides the export panel: content, format, file and print check.", canShow, show},
    {"export.pieces", "", "", "", "WHICH [NAME]",
     "Sets the content of the export: all (one file), each (one file per piece), put-back (at the scan positions), "
     "piece NAME, or beside NAME (a neighbour).",
     isShown, choose},
    {"export.format", "", "", "", "FORMAT", "Sets the format of the file: stl, 3mf or another writable format.",
     isShown, format},
    {"export.to", "", "", "", "PATH", "Sets the file to write. Its extension sets the format.", isShown, to},
    {"export.check", "", "", "", "", "Repeats the print check without writing a file.", isShown, check},
    {"export.write", "", "", "", "[replace] [anyway]",
     "Writes the file, reads it back and checks it. replace: overwrites an existing file. anyway: also writes a mesh "
     "that failed the print check.",
     isShown, write},
    {"export.show-in-folder", "File:3", "Show export in folder", "", "",
     "Shows the last exported file in the file manager.", isWritten, showInFolder},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::export_commands
