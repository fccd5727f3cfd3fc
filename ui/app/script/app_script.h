// Scripts for the window: user actions as lines of text.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Words of a script line. Blanks separate words, double quotes group them, # begins a comment.
Expected<std::vector<std::string>> wordsOfLine(const std::string& line);

/// Runs the lines of a script, in the syntax of wordsOfLine(). window_help.cpp describes the commands beyond the table:
/// `wait`, `print` and `expect`. The first error ends the script and names the line.
/// @param frame  called about 60 times a second during waits.
Expected<void> runScript(AppContext& context, const std::filesystem::path& script, const std::function<void()>& frame);

/// Implements `wait`: returns when no job runs, no plane is being sawn, and a replay has reached its target.
Expected<void> waitUntilSettled(AppContext& context, const std::function<void()>& frame);

}  // namespace kerf
