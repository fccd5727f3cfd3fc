// Finds a command by words, prompts for its parameters in the same line, and runs it. Model of the palette, no window.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Commands with every word in their label, id, menu or description, English or translated, in any case. Matches in the
/// label come first; ties keep the order of the table. No words: all commands.
std::vector<const AppCommand*> findAppCommands(std::string_view words);

class CommandPalette {
 public:
  void show();
  void hide() { is_shown_ = false; }
  bool isShown() const { return is_shown_; }

  // ---- The line

  const std::string& text() const { return text_; }
  void type(std::string_view characters);  ///< UTF-8
  /// Deletes the last character; in an empty line, drops the command that waits for parameters.
  void erase();
  /// Escape: back to the list, or closes the palette.
  void back();
  /// The command that waits for its parameters; null during the search.
  const AppCommand* asked() const { return asked_; }
  /// Why the last accept() did nothing; empty: it succeeded.
  const std::string& error() const { return error_; }

  // ---- The list

  const std::vector<const AppCommand*>& found() const { return found_; }
  std::size_t selected() const { return selected_; }
  void move(int rows);  ///< stops at the ends
  void select(std::size_t n);

  /// Enter: runs the selected command, or prompts for its parameters. "cut.force 2" runs at once. If the command is
  /// disabled or fails, its text stays in the line, with error().
  /// @return a command that needs a path: the caller prompts for it. Else null.
  const AppCommand* accept(AppContext& context);

 private:
  void search();
  const AppCommand* runOrSay(AppContext& context, const AppCommand& command, AppWords words);

  bool is_shown_ = false;
  std::string text_, error_;
  const AppCommand* asked_ = nullptr;
  std::vector<const AppCommand*> found_;
  std::size_t selected_ = 0;
};

}  // namespace kerf
