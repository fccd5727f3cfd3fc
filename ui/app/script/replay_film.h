// A replay as a sequence of pictures, at even steps of the session's own time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>

#include "ui/app/commands/app_commands.h"

namespace kerf {

struct FilmOptions {
  std::filesystem::path folder;  ///< new, or empty
  double fps = 10;               ///< pictures per simulated second
  double from_s = 0, until_s = std::numeric_limits<double>::infinity();

  static constexpr double kMostFps = 1000;  ///< one picture per tick
  static constexpr std::size_t kMostPictures = 20'000;
};

/// Writes frame-00001.png, frame-00002.png, ... of the session that `context` watches: the first at from_s, the last no
/// later than until_s or the end. Each shows the state after its tick, bit for bit as it was cut.
/// @param frame  called about 60 times a second during waits.   @pre context.screenshot draws.
/// @return  number of pictures.   Errors: kBadValue for options out of range; kWriteFailed, also for a folder that is
/// not empty; kUnsupported if no session is watched; those of drawing. Pictures written so far stay.
Expected<std::size_t> filmReplay(AppContext& context, const FilmOptions& options, const std::function<void()>& frame);

}  // namespace kerf
