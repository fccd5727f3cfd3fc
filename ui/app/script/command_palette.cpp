#include "ui/app/script/command_palette.h"
#include "ui/app/script/app_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>

#include "ui/app/base/language.h"

namespace kerf {
namespace {

// Also lowers Latin-1 letters in UTF-8.
std::string lower(std::string_view text) {
  std::string out(text);
  unsigned char before = 0;
  for (char& c : out) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_capital = before == 0xC3 && byte >= 0x80 && byte <= 0x9E && byte != 0x97;
    c = static_cast<char>(is_capital ? byte + 0x20 : std::tolower(byte));
    before = byte;
  }
  return out;
}

enum class Place { kNowhere, kWithin, kWordStart, kStart };

// Best position of a word in a text.
Place placeOf(std::string_view text, const std::string& word) {
  const std::string in = lower(text);
  Place best = Place::kNowhere;
  for (std::size_t at = in.find(word); at != in.npos; at = in.find(word, at + 1)) {
    const bool begins = at == 0 || !std::isalnum(static_cast<unsigned char>(in[at - 1]));
    best = std::max(best, at == 0 ? Place::kStart : begins ? Place::kWordStart : Place::kWithin);
  }
  return best;
}

// In English or translated.
Place placeOfText(std::string_view text, const std::string& word) {
  return std::max(placeOf(text, word), placeOf(shownText(text), word));
}

// 0: the word does not occur.
int scoreOf(const AppCommand& command, const std::string& word) {
  const Place label = placeOfText(command.label, word), id = placeOf(command.id, word);
  const bool is_menu = lower(menuOf(command)) == word || lower(shownText(menuOf(command))) == word;
  if (label == Place::kStart || is_menu) return 6;
  if (label == Place::kWordStart) return 5;
  if (id >= Place::kWordStart) return 4;
  if (placeOfText(menuOf(command), word) >= Place::kWordStart) return 3;
  if (label != Place::kNowhere || id != Place::kNowhere) return 2;
  return placeOfText(command.description, word) != Place::kNowhere ? 1 : 0;
}

bool needsParameters(const AppCommand& command) {
  return !command.parameters.empty() && !command.parameters.starts_with('[');
}

}  // namespace

std::vector<const AppCommand*> findAppCommands(std::string_view words) {
  std::vector<std::string> wanted;
  std::istringstream in{lower(words)};
  for (std::string word; in >> word;) wanted.push_back(word);

  std::vector<std::pair<int, const AppCommand*>> scored;
  for (const AppCommand& command : appCommands()) {
    int all = 0;
    const bool fits = std::all_of(wanted.begin(), wanted.end(), [&](const std::string& word) {
      const int score = scoreOf(command, word);
      all += score;
      return score > 0;
    });
    if (fits) scored.emplace_back(all, &command);
  }
  std::stable_sort(scored.begin(), scored.end(), [](const auto& a, const auto& b) { return a.first > b.first; });

  std::vector<const AppCommand*> out;
  out.reserve(scored.size());
  for (const auto& [score, command] : scored) out.push_back(command);
  return out;
}

void CommandPalette::show() {
  is_shown_ = true;
  asked_ = nullptr;
  text_.clear();
  search();
}

void CommandPalette::search() {
  error_.clear();
  selected_ = 0;
  if (asked_) return;
  found_ = findAppCommands(text_);
  // Parameters after an id: "cut.force 2"; optional ones too: "saw.cut 8".
  const std::size_t blank = text_.find(' ');
  const AppCommand* const whole = findAppCommand(std::string_view(text_).substr(0, blank));
  const bool has_parameters = whole && !whole->parameters.empty();
  if (has_parameters && (needsParameters(*whole) || blank != text_.npos)) found_ = {whole};
}

void CommandPalette::type(std::string_view characters) {
  text_ += characters;
  search();
}

void CommandPalette::erase() {
  if (text_.empty()) {
    asked_ = nullptr;
  } else {
    while (text_.size() > 1 && (static_cast<unsigned char>(text_.back()) & 0xC0) == 0x80) text_.pop_back();
    text_.pop_back();
  }
  search();
}

void CommandPalette::back() {
  if (!asked_) return hide();
  asked_ = nullptr;
  text_.clear();
  search();
}

void CommandPalette::move(int rows) {
  if (found_.empty()) return;
  const auto last = static_cast<std::ptrdiff_t>(found_.size()) - 1;
  selected_ =
      static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(selected_) + rows, 0, last));
  error_.clear();
}

void CommandPalette::select(std::size_t n) {
  if (n < found_.size()) selected_ = n;
}

const AppCommand* CommandPalette::runOrSay(AppContext& context, const AppCommand& command, AppWords words) {
  const auto done = runAppCommand(context, command.id, words);
  if (done)
    hide();
  else
    error_ = done.error().message();
  return nullptr;
}

const AppCommand* CommandPalette::accept(AppContext& context) {
  error_.clear();
  if (!asked_ && selected_ >= found_.size()) {
    error_ = "no command matches";
    return nullptr;
  }
  const AppCommand& command = asked_ ? *asked_ : *found_[selected_];
  if (!command.is_enabled(context)) {
    error_ = "this command is not available now";
    return nullptr;
  }

  // Parameters: the whole line, or the text after an id.
  const bool names_it = !asked_ && text_.starts_with(command.id) && text_.find(' ') == command.id.size();
  if (asked_ || names_it) {
    const auto words = wordsOfLine(asked_ ? text_ : text_.substr(command.id.size()));
    if (!words) {
      error_ = words.error().message();
      return nullptr;
    }
    if (!words->empty()) return runOrSay(context, command, *words);
  }

  if (asksForFile(command)) {
    hide();
    return &command;
  }
  if (needsParameters(command)) {
    if (asked_) error_ = fmt::format("expected {}", command.parameters);
    asked_ = &command;
    text_.clear();
    return nullptr;
  }
  return runOrSay(context, command, {});
}

}  // namespace kerf
