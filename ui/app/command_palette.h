// Finds a command by words, asks for its parameters in the same line, and runs it. The model of the palette: no window.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "ui/app/app_commands.h"

namespace kerf {

/// Commands in whose label, id, menu or description every word occurs, whatever its case, in English or as they are
/// shown; those where it stands in the label first, then by the table. No words: all of them.
std::vector<const AppCommand*> findAppCommands(std::string_view words);

class CommandPalette {
 public:
  void show();
  void hide() { is_shown_ = false; }
  bool isShown() const { return is_shown_; }

  // ---- The line

  const std::string& text() const { return text_; }
  void type(std::string_view characters);  ///< UTF-8
  /// Deletes the last character; in an empty line the command that parameters are asked for is let go.
  void erase();
  /// Escape: back to the list, or away.
  void back();
  /// Null: commands are searched; else its parameters are typed.
  const AppCommand* asked() const { return asked_; }
  /// Why the last accept() did nothing; empty: it did.
  const std::string& error() const { return error_; }

  // ---- The list

  const std::vector<const AppCommand*>& found() const { return found_; }
  std::size_t selected() const { return selected_; }
  void move(int rows);  ///< stops at the ends
  void select(std::size_t n);

  /// Enter: runs the selected command, or asks for its parameters. "cut.force 2" runs at once. What is not enabled now
  /// or is refused stays in the line, with error().
  /// @return a command that needs a path: the caller asks for it. Else null.
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
