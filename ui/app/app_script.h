// Scripts for the window: what a person would do, as lines.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "ui/app/app_commands.h"

namespace kerf {

/// The words of a line of a script: blanks part them, double quotes keep them together, # begins a comment.
Expected<std::vector<std::string>> wordsOfLine(const std::string& line);

/// Lines of commands; # begins a comment; words in double quotes may hold blanks. Beside the commands of the table:
///   wait               until no job runs and no plane is sawn
///   wait SECONDS       of the simulation
///   print              state as one line of JSON on standard output
///   expect WHAT LOW HIGH  ends the script unless removed (mm^3), depth (mm), near (mm from the tool that cuts to pulp
///                      or nerve), warm (C, of the tissue under the tool), sawn (percent of the plane sawn last),
///                      triangles, pieces, steps (done, since the session began) or ahead (steps that were taken back)
///                      is in that range
/// The first error ends it, and names the line.   @param frame  is called about 60 times a second while it waits.
Expected<void> runScript(AppContext& context, const std::filesystem::path& script, const std::function<void()>& frame);

/// What `wait` does: until no job runs, no plane is sawn, and a replay has come where it was sent.
Expected<void> waitUntilSettled(AppContext& context, const std::function<void()>& frame);

}  // namespace kerf
