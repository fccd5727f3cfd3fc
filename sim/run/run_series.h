// A run against resistance over time: force, drive, temperature, distances, removed volume, a value a tick.
//
// A run along a path has kept them: forces.csv. A session by hand has them in its log, which is replayed.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/live/stroke_peaks.h"
#include "sim/run/run_manifest.h"
#include "sim/session/session_log.h"

namespace kerf {

/// A stretch of a run in which the tool was meant to cut, s.
struct StrokeSpan {
  double from_s = 0, to_s = 0;
};

/// Values of one length: those of a tick stand at the same index.
struct RunSeries {
  std::vector<float> t_s;                ///< at the end of the tick; rises
  std::vector<float> contact_N, hand_N;  ///< size of the force on the tool, and of that to the hand
  std::vector<float> speed;              ///< of the drive: rad/s; of a reciprocating blade mm/s
  std::vector<float> drive_load;         ///< N mm; of a reciprocating blade N
  std::vector<float> temperature_C;      ///< of the tissue under the tool
  std::vector<float> removed_mm3;        ///< of the case that is cut, so far: an undo lets it fall

  /// From what cuts of the tool to a structure or a neighbour, mm; negative: in it. NaN: too far to be measured.
  struct Distance {
    std::string id;  ///< "pulp", "nerve_canal", "beside_1"
    std::vector<float> mm;
  };
  std::vector<Distance> distances;

  std::vector<StrokeSpan> strokes;  ///< in their order
  /// Of a log: by strokes, those that were taken back apart. None: nothing was taken back.
  std::optional<SessionPeaks> peaks;
  bool has_spinning_tool = true, has_reciprocating_tool = false;
  std::string source;  ///< "forces.csv", or "session.kerflog, replayed"

  std::size_t size() const { return t_s.size(); }
};

/// Errors: kUnsupported for a run that was cut by geometry alone, which has no time, and for a session that has not
/// ended; kBadFormat for a forces.csv that is not one, naming the line; kBadValue for a log that can not be replayed to
/// the same bits; those of loading; kCancelled.
/// @cost  of a forces.csv about 1 s for a minute; of a log about a quarter of the session's time, and seconds to load.
Expected<RunSeries> readRunSeries(const std::filesystem::path& run_folder, const Progress& progress = {});

/// Strokes by their marks in a log; one that is not ended goes on to the last sample.
std::vector<StrokeSpan> strokesOf(const SessionLog& log);

}  // namespace kerf
