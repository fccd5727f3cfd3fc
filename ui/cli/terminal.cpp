#include <errno.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string_view>

#include "geometry/base/assets.h"
#include "sim/run/files/run_files.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

std::atomic<int> interrupted{0};    // by this signal
std::atomic<bool> is_asked{false};  // a callback was taken
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "set from a signal handler");

constexpr std::array kTerminalSignals = {SIGINT, SIGTERM, SIGHUP};

// Stopped work must call its callback within a second, or the program ends. It then has two more seconds to clean up.
// Ending is always safe: partial files lie beside their targets, and the next run sweeps them.
constexpr unsigned kToLookUp = 1, kToCleanUp = 2;  // s

void endAtOnce(int) { ::_exit(128 + interrupted); }

void onSignal(int signal) {
  if (interrupted.exchange(signal) == 0) {
    if (signal != SIGINT && is_asked) ::alarm(kToLookUp);  // at a terminal a second Ctrl-C ends it
    return;
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

constexpr char kEraseLine[] = "\r\033[K";

// For work without files.
void eraseAndEnd(int signal) {
  if (isatty(STDERR_FILENO) == 1 && ::write(STDERR_FILENO, kEraseLine, sizeof kEraseLine - 1) < 0)
    ::_exit(128 + signal);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

namespace {

// The error for answerInJson().
std::optional<Error> complained_of;
bool has_printed_json = false;

}  // namespace

int complain(const Error& error) {
  complained_of = error;
  printText(stderr, "{}: {}\n", program_invocation_short_name, printable(error.message()));
  return kFailed;
}

int complainOfUsage(const Error& error) {
  complain(error);
  return kUsage;
}

void answerInJson() {
  if (!complained_of || has_printed_json) return;
  printJson(errorJson(*complained_of, complained_of->message()));
}

void printJson(const nlohmann::json& json) {
  has_printed_json = true;
  printText("{}\n", printableJson(json));
}

int runProgram(CLI::App& app, int argc, const char* const* argv, const int& exit_code) {
  requireFiniteNumbers(app);
  const auto has = [&](std::string_view word) { return std::find(argv, argv + argc, word) != argv + argc; };
  const auto answered = [&has](int code) {
    if (has("--json")) answerInJson();
    return code;
  };
  const bool is_help = argc > 1 && std::string_view(argv[1]) == "help";
  if (!is_help && !has("--help") && !has("-h") && !has("--version"))
    if (const auto assets = requireAssets(); !assets) return answered(complain(assets.error()));

  try {
    if (const auto end = parseCommandLine(app, argc, argv)) return *end;
  } catch (const std::exception& e) {
    return complain(
        {.code = Error::Code::kBadValue, .found = fmt::format("unexpected: {}", e.what()), .hint = "report this bug"});
  }
  answered(exit_code);

  // A lost report (full disk behind a redirection) is a failure.
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    return complain({.code = Error::Code::kWriteFailed, .place = "standard output", .found = "could not be written"});
  return exit_code;
}

void addOverwrite(CLI::App& command, bool& overwrites, const std::string& description) {
  command.add_flag("--overwrite", overwrites, description);
  command.add_flag("--force", overwrites, "the old name of --overwrite")->group("");
}

Expected<void> requireFree(const std::filesystem::path& file, bool overwrites) {
  std::error_code failed;
  if (overwrites || !std::filesystem::exists(std::filesystem::symlink_status(file, failed))) return {};
  return fail({.code = Error::Code::kBadValue,
               .file = file.string(),
               .found = "exists already",
               .expected = "a new file",
               .hint = "another name, or --overwrite to replace it"});
}

void addCasePlaces(CLI::App& command) {
  command
      .add_option_function<std::vector<std::string>>(
          "--case",
          [](const std::vector<std::string>& folders) {
            setPlacesOfCases({folders.begin(), folders.end()});
          },
          "folder of the case if the run was moved without it. Repeat for the cases of neighbours")
      ->type_name("FOLDER")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

std::string counted(std::size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

TerminalProgress::TerminalProgress(bool writes_files) : is_terminal_(isatty(STDERR_FILENO) == 1), start_(seconds()) {
  // The first signal asks the work to stop and clean up; the second one, of any kind, kills.
  struct sigaction action {};
  action.sa_handler = writes_files ? onSignal : eraseAndEnd;
  for (std::size_t n = 0; n < kTerminalSignals.size(); ++n) {
    sigaction(kTerminalSignals[n], &action, &before_[n]);
    if (before_[n].sa_handler == SIG_IGN) sigaction(kTerminalSignals[n], &before_[n], nullptr);  // as under nohup
  }
  std::signal(SIGALRM, endAtOnce);
}

TerminalProgress::~TerminalProgress() {
  clear();
  ::alarm(0);
  bool is_awaited = !is_asked;  // or an outer handler waits for a signal: Interruption
  for (std::size_t n = 0; n < kTerminalSignals.size(); ++n) {
    sigaction(kTerminalSignals[n], &before_[n], nullptr);
    is_awaited |= kTerminalSignals[n] == interrupted && before_[n].sa_handler != SIG_DFL;
  }
  if (is_awaited && interrupted != 0) std::raise(interrupted);  // delayed, not swallowed
}

void TerminalProgress::clear() {
  if (is_terminal_ && !last_what_.empty()) std::fputs(kEraseLine, stderr);
  last_what_.clear();
}

Progress TerminalProgress::callback() {
  is_asked = true;
  return [this](double fraction, std::string_view what) {
    if (interrupted != 0) {
      if (!has_looked_up_ && interrupted != SIGINT) ::alarm(kToCleanUp);
      has_looked_up_ = true;
      return false;
    }
    const int percent = static_cast<int>(100 * fraction);
    if (is_terminal_ && (percent != last_percent_ || what != last_what_)) {
      last_percent_ = percent;
      last_what_ = what;

      const double spent = seconds() - start_;
      const std::string left = fraction > 0.05 && spent > 1
                                   ? fmt::format(", {:.0f} s left", spent * (1 - fraction) / fraction)
                                   : std::string();
      const std::string bar(static_cast<std::size_t>(percent / 5), '#');
      std::fputs(fmt::format("\r\033[K[{:<20}] {:3d} %  {}{}", bar, percent, printable(what), left).c_str(), stderr);
      std::fflush(stderr);
    }
    return true;
  };
}

}  // namespace kerf::cli
