// A run against resistance over time: force, drive, temperature, distances, removed volume, one value a tick.
//
// A run along a path has them in forces.csv. A session by hand has them in its log, which is replayed.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/live/stroke_peaks.h"
#include "sim/run/files/run_manifest.h"
#include "sim/session/session_log.h"

namespace kerf {

/// A stretch of a run in which the tool was meant to cut, s.
struct StrokeSpan {
  double from_s = 0, to_s = 0;
};

/// Arrays of one length: the values of a tick have the same index.
struct RunSeries {
  std::vector<float> t_s;                ///< end of the tick; increasing
  std::vector<float> contact_N, hand_N;  ///< magnitude of the force on the tool, and of that to the hand
  std::vector<float> speed;              ///< of the drive: rad/s; of a reciprocating blade mm/s
  std::vector<float> drive_load;         ///< N mm; of a reciprocating blade N
  std::vector<float> temperature_C;      ///< of the tissue under the tool
  std::vector<float> removed_mm3;        ///< of the case, so far: an undo lowers it

  /// From the tool's cutting part to a structure or a neighbour, mm; negative: inside. NaN: too far to be measured.
  struct Distance {
    std::string id;  ///< "pulp", "nerve_canal", "beside_1"
    std::vector<float> mm;
  };
  std::vector<Distance> distances;

  std::vector<StrokeSpan> strokes;  ///< in their order
  /// From a log: peaks by strokes, undone ones separate. None: no undo.
  std::optional<SessionPeaks> peaks;
  bool has_spinning_tool = true, has_reciprocating_tool = false;
  std::string source;  ///< "forces.csv", or "session.kerflog, replayed"

  std::size_t size() const { return t_s.size(); }
};

/// Errors: kUnsupported for a geometry-only run, which has no time, and for a session that has not ended; kBadFormat
/// for an invalid forces.csv, with the line; kBadValue for a log that does not replay to the same bits; those of
/// loading; kCancelled.
/// @cost  of a forces.csv about 1 s for a minute; of a log about a quarter of the session's time, and seconds to load.
Expected<RunSeries> readRunSeries(const std::filesystem::path& run_folder, const Progress& progress = {});

/// Strokes by their marks in a log; an unended one extends to the last sample.
std::vector<StrokeSpan> strokesOf(const SessionLog& log);

}  // namespace kerf
