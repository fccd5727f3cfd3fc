#include "ui/window/screens/file_chooser.h"

#include <string>
#include <utility>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/scene_pieces.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

bool isToOpen(const AppCommand& command) {
  for (const char* const id :
       {"file.open", "file.open-beside", "import.read", "import.add", "replay.open", "tool.add", "saw.load"})
    if (command.id == id) return true;
  return false;
}

// The user reviews a scan before preparation, and may open several files together.
bool takesSeveral(const AppCommand& command) { return command.id == "file.open"; }

std::string suggestedName(const AppContext& context, const AppCommand& command) {
  if (isToOpen(command)) return "";
  if (command.id == "export.to") return context.bench.exporting->file().filename().string();
  if (command.id == "file.save-as") return context.bench.document->name() + ".kerf";
  return context.bench.document->name() + "-cut.stl";
}

// A session is looked for where Kerf writes them. That folder is not kept for other files.
bool isOfSessions(const AppCommand& command) { return command.id == "replay.open"; }

std::optional<std::uint32_t> chosenPiece(const AppContext& context) {
  const SceneObject* const piece = context.bench.pieces->chosen();
  return piece ? std::optional(piece->id) : std::nullopt;
}

}  // namespace

void FileChooser::ask(AppContext& context, const AppCommand& command) {
  dialog_.close();
  asked_for_ = &command;
  generation_ = context.bench.document->generation();
  piece_ = chosenPiece(context);
  if (before_sessions_) browser_.setFolder(*std::exchange(before_sessions_, std::nullopt));
  if (isOfSessions(command)) {
    before_sessions_ = browser_.folder();
    browser_.setFolder(context.bench.options().data_folder / "sessions");
  }
  const bool is_own = context.settings && context.settings->values.has_own_dialog;
  if (is_own || !SystemDialog::program()) return askInside(context);

  using What = FileQuestion::What;
  FileQuestion question;
  question.title = shownText(command.label.empty() ? "Export to" : command.label);
  question.folder = browser_.folder();
  question.name = suggestedName(context, command);
  if (command.id == "replay.open")
    question.what = What::kOpenFolder;
  else if (!isToOpen(command))
    question.what = What::kSave;
  else if (takesSeveral(command))
    question.what = What::kOpenSeveral;
  if (const auto asked = dialog_.ask(question); !asked) {
    context.bench.notices->complain(asked.error());
    askInside(context);
  }
}

void FileChooser::askInside(const AppContext& context) {
  browser_.show(isToOpen(*asked_for_) ? FileBrowser::Purpose::kOpen : FileBrowser::Purpose::kSave,
                suggestedName(context, *asked_for_), takesSeveral(*asked_for_));
  browser_.setSaveLabel(asked_for_->id == "file.save-as" ? "Save" : "Export");
}

void FileChooser::update(AppContext& context) {
  if (const auto file = browser_.draw()) {
    std::vector<fs::path> files = browser_.takeOthers();
    files.insert(files.begin(), *file);
    keepFolder(context, browser_.folder());
    take(context, std::move(files));
  }
  takeAnswer(context);
}

void FileChooser::takeAnswer(AppContext& context) {
  auto answer = dialog_.poll();
  if (!answer) return;
  if (!*answer) {
    context.bench.notices->complain(answer->error());
    return askInside(context);
  }
  if ((*answer)->empty()) return;  // cancelled
  keepFolder(context, (*answer)->front().parent_path());
  take(context, std::move(**answer));
}

void FileChooser::keepFolder(AppContext& context, const fs::path& folder) {
  browser_.setFolder(folder);
  if (asked_for_ && isOfSessions(*asked_for_)) return;
  if (!context.settings || folder == context.settings->values.last_folder) return;
  context.settings->values.last_folder = folder;
  if (const auto kept = context.settings->save(); !kept && !context.settings->error())
    context.bench.notices->complain(kept.error());
}

void FileChooser::take(AppContext& context, std::vector<fs::path> files) {
  if (!asked_for_) return;
  // Not the document the user confirmed: would write another one.
  if (!isToOpen(*asked_for_) && (generation_ != context.bench.document->generation() || piece_ != chosenPiece(context)))
    return context.bench.notices->complain(
        {.code = Error::Code::kUnsupported,
         .file = files.front().string(),
         .found = "the open object or the chosen piece changed after the dialog opened",
         .expected = "no change; Kerf wrote nothing",
         .hint = "choose the command again"});
  const bool is_open = asked_for_->id == "file.open";
  if (is_open && files.size() > 1 && asked_for_->is_enabled(context)) return context.bench.imports->addMore(files);
  // In a script file.open takes the defaults.
  const AppCommand* const command = is_open ? findAppCommand("import.read") : asked_for_;
  const std::vector<std::string> words{files.front().string()};
  if (const auto done = runAppCommand(context, command->id, words); !done)
    context.bench.notices->complain(done.error());
}

}  // namespace kerf
