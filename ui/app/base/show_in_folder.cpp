#include "ui/app/base/show_in_folder.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <string_view>
#include <utility>

#include "ui/app/base/desktop_program.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// xdg-open may run as long as the file manager: without failure by then it counts as shown.
constexpr auto kLongest = std::chrono::seconds(3);

bool isUnreserved(char c) {
  const std::string_view marks = "-._~/";
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || marks.find(c) != marks.npos;
}

fs::path absolutePathOf(const fs::path& file) {
  std::error_code failed;
  const fs::path out = fs::absolute(file, failed);
  return failed ? file : out.lexically_normal();
}

std::string howItEnded(int status) {
  if (WIFSIGNALED(status)) return fmt::format("killed by signal {}", WTERMSIG(status));
  return fmt::format("exit code {}", WEXITSTATUS(status));
}

}  // namespace

std::string uriOf(const fs::path& file) {
  std::string out = "file://";
  for (const char c : absolutePathOf(file).string())
    isUnreserved(c) ? out += c : out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  return out;
}

// Commas divide the elements of an array: a URI has none. A reply shows that there is a file manager.
std::vector<std::string> showItemsCommand(std::span<const fs::path> files) {
  std::string uris;
  for (const fs::path& file : files) uris += (uris.empty() ? "" : ",") + uriOf(file);
  return {"dbus-send",
          "--session",
          "--print-reply",
          "--reply-timeout=5000",
          "--dest=org.freedesktop.FileManager1",
          "--type=method_call",
          "/org/freedesktop/FileManager1",
          "org.freedesktop.FileManager1.ShowItems",
          "array:string:" + uris,
          "string:"};
}

tl::unexpected<Error> ShowInFolder::notShown(std::string found) const {
  return fail({.code = Error::Code::kUnsupported,
               .place = "show in folder",
               .found = std::move(found),
               .expected = "a file manager",
               .hint = "open the folder yourself: " + absolutePathOf(files_.front()).parent_path().string()});
}

Expected<void> ShowInFolder::begin(std::vector<fs::path> files) {
  files_ = std::move(files);
  child_ = 0;
  is_by_bus_ = isOnPath("dbus-send");
  if (!is_by_bus_) return openFolder();
  const auto started = startProgram(showItemsCommand(files_));
  if (!started) return openFolder();
  child_ = *started;
  return {};
}

Expected<void> ShowInFolder::openFolder() {
  is_by_bus_ = false;
  if (!isOnPath("xdg-open")) return notShown("no file manager on D-Bus, and no xdg-open");
  const auto started = startProgram({"xdg-open", absolutePathOf(files_.front()).parent_path().string()});
  if (!started) return notShown(started.error().found);
  child_ = *started;
  began_ = std::chrono::steady_clock::now();
  return {};
}

std::optional<Expected<void>> ShowInFolder::poll() {
  if (child_ <= 0) return {};
  const std::optional<int> status = endOf(child_);
  if (!status) {
    const bool is_shown = !is_by_bus_ && std::chrono::steady_clock::now() > began_ + kLongest;
    if (!is_shown) return {};
    child_ = 0;
    return Expected<void>{};
  }
  child_ = 0;
  if (WIFEXITED(*status) && WEXITSTATUS(*status) == 0) return Expected<void>{};
  if (!is_by_bus_) return Expected<void>(notShown("xdg-open: " + howItEnded(*status)));
  if (const auto opened = openFolder(); !opened) return Expected<void>(fail(opened.error()));
  return {};
}

}  // namespace kerf
