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

/// Runs the lines of a script, in the syntax of wordsOfLine(). Commands beyond the table:
///   wait               as waitUntilSettled()
///   wait SECONDS       in simulation time
///   print              prints the state as one line of JSON on standard output
///   expect WHAT LOW HIGH  ends the script if a value is out of range: removed (mm^3), depth (mm), near (mm from the
///                      cutting tool to pulp or nerve), warm (C, tissue under the tool), sawn (percent of the last
///                      plane), triangles, pieces, steps (done, since the session began), ahead (undone steps)
/// The first error ends the script and names the line.   @param frame  called about 60 times a second during waits.
Expected<void> runScript(AppContext& context, const std::filesystem::path& script, const std::function<void()>& frame);

/// Implements `wait`: returns when no job runs, no plane is being sawn, and a replay has reached its target.
Expected<void> waitUntilSettled(AppContext& context, const std::function<void()>& frame);

}  // namespace kerf
