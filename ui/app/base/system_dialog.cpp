#include "ui/app/base/system_dialog.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <utility>

#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_formats.h"
#include "sim/run/files/run_manifest.h"
#include "ui/app/base/desktop_program.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using What = FileQuestion::What;

constexpr int kCancelled = 1;  // exit code of both programs

// "*.stl *.STL ...": scanners write both. Includes sessions, files of a CT and recipes.
std::string patterns() {
  std::string all = ".kerf .toml .nrrd .nii .nii.gz .mha .mhd";
  for (const MeshFormatRow& row : meshFormats())
    if (row.read) all += " " + std::string(row.extensions);

  std::string out;
  std::istringstream words(all);
  for (std::string word; words >> word;) {
    std::string capitals = word;
    for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    out += fmt::format("{}*{} *{}", out.empty() ? "" : " ", word, capitals);
  }
  return out;
}

// With a trailing slash: a start folder, not a file to choose.
std::string beginningOf(const FileQuestion& question) {
  std::error_code gone;
  const fs::path folder = question.folder.empty() ? fs::current_path(gone) : question.folder;
  return (folder / question.name).string();
}

std::vector<std::string> zenityCommand(const FileQuestion& question) {
  std::vector<std::string> out{"zenity", "--file-selection", "--title=" + question.title,
                               "--filename=" + beginningOf(question)};
  switch (question.what) {
    case What::kSave:
      out.insert(out.end(), {"--save", "--confirm-overwrite"});
      return out;
    case What::kOpenFolder:
      out.push_back("--directory");
      return out;
    case What::kOpenSeveral:
      out.insert(out.end(), {"--multiple", "--separator=\n"});
      break;
    case What::kOpen:
      break;
  }
  out.push_back("--file-filter=Scans, recipes, cases, CTs | " + patterns());
  out.push_back("--file-filter=All files | *");
  return out;
}

std::vector<std::string> kdialogCommand(const FileQuestion& question) {
  std::vector<std::string> out{"kdialog", "--title", question.title};
  switch (question.what) {
    case What::kSave:
      out.push_back("--getsavefilename");
      break;
    case What::kOpenFolder:
      out.push_back("--getexistingdirectory");
      break;
    case What::kOpenSeveral:
      out.insert(out.end(), {"--multiple", "--separate-output", "--getopenfilename"});
      break;
    case What::kOpen:
      out.push_back("--getopenfilename");
      break;
  }
  out.push_back(beginningOf(question));
  return out;
}

/// Maps the manifest of a case to its folder.
fs::path meantBy(const fs::path& chosen) {
  const fs::path folder = chosen.parent_path();
  const bool is_manifest =
      (chosen.filename() == kCaseManifest && isCase(folder)) || (chosen.filename() == kRunManifest && isRun(folder));
  return is_manifest ? folder : chosen;
}

tl::unexpected<Error> failed(std::string found) {
  return fail({.code = Error::Code::kUnsupported,
               .place = "the system's file dialog",
               .found = std::move(found),
               .expected = "a dialog",
               .hint = "use Kerf's own browser: in Settings, or with settings.dialog own"});
}

}  // namespace

std::vector<std::string> commandOf(const std::string& program, const FileQuestion& question) {
  return program == "kdialog" ? kdialogCommand(question) : zenityCommand(question);
}

std::optional<std::string> SystemDialog::program() {
  for (const char* const name : {"zenity", "kdialog"})
    if (isOnPath(name)) return name;
  return {};
}

SystemDialog::~SystemDialog() { close(); }

void SystemDialog::close() {
  if (out_ >= 0) ::close(std::exchange(out_, -1));
  if (child_ <= 0) return;
  ::kill(child_, SIGKILL);
  while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
  child_ = 0;
}

Expected<void> SystemDialog::ask(const FileQuestion& question) {
  const auto name = program();
  if (!name)
    return fail({.code = Error::Code::kNotFound,
                 .found = "neither zenity nor kdialog",
                 .expected = "one of them on the PATH",
                 .hint = "apt install zenity"});
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) return failed(*name + ": " + std::strerror(errno));

  const auto child = startProgram(commandOf(*name, question), pipe[1]);
  ::close(pipe[1]);
  if (!child) {
    ::close(pipe[0]);
    return failed(child.error().found);
  }

  ::fcntl(pipe[0], F_SETFL, O_NONBLOCK);
  child_ = *child;
  out_ = pipe[0];
  what_ = question.what;
  program_ = *name;
  text_.clear();
  return {};
}

std::optional<Expected<FileAnswer>> SystemDialog::poll() {
  if (child_ <= 0) return {};
  const auto takeText = [&] {
    std::array<char, 4096> bytes{};
    for (ssize_t n = 0; (n = ::read(out_, bytes.data(), bytes.size())) > 0;)
      text_.append(bytes.data(), static_cast<std::size_t>(n));
  };
  takeText();
  const std::optional<int> status = endOf(child_);
  if (!status) return {};
  takeText();  // the last output
  child_ = 0;
  ::close(std::exchange(out_, -1));
  if (*status == -1) return Expected<FileAnswer>(failed(program_ + ": no exit code"));
  return answerOf(*status);
}

Expected<FileAnswer> SystemDialog::answerOf(int status) const {
  if (WIFSIGNALED(status)) return failed(fmt::format("{}: killed by signal {}", program_, WTERMSIG(status)));
  const int code = WEXITSTATUS(status);
  if (code == kCancelled) return FileAnswer{};
  if (code != 0) return failed(fmt::format("{}: exit code {}", program_, code));

  FileAnswer out;
  if (what_ != What::kOpenSeveral) {  // a name may contain newlines
    const std::string path = text_.ends_with('\n') ? text_.substr(0, text_.size() - 1) : text_;
    if (!path.empty()) out.push_back(what_ == What::kOpen ? meantBy(path) : fs::path(path));
    return out;
  }
  std::istringstream lines(text_);
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) out.push_back(meantBy(line));
  return out;
}

}  // namespace kerf
