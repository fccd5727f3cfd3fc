// A chart of a run over time, as SVG: panels below each other over one time axis.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "sim/run/report/run_series.h"

namespace kerf {

/// Content of a panel.
enum class ChartPanel { kForce, kLoad, kSpeed, kTemperature, kDistance, kRemoved };

struct ChartPanelRow {
  const char* name;  ///< as typed
  ChartPanel panel;
};
/// From the top down.
inline constexpr std::array<ChartPanelRow, 6> kChartPanels{{{"force", ChartPanel::kForce},
                                                            {"load", ChartPanel::kLoad},
                                                            {"speed", ChartPanel::kSpeed},
                                                            {"temperature", ChartPanel::kTemperature},
                                                            {"distance", ChartPanel::kDistance},
                                                            {"removed", ChartPanel::kRemoved}}};

struct ChartOptions {
  std::vector<ChartPanel> panels;  ///< in any order; empty: all panels for which the run has data
  double from_s = 0, until_s = std::numeric_limits<double>::infinity();
  std::string title;
  std::string subtitle;
};

/// On white, in colours that colour-blind readers can tell apart, also by lightness. For each pixel column a line shows
/// the least and the largest value of its ticks, so no peak is lost. Largest values, or the least distance, are marked
/// with number and time; strokes are bands.
/// Error kEmpty: no tick between from_s and until_s.   @cost  50 ms for ten minutes; at most 200 KB.
Expected<std::string> drawChart(const RunSeries& series, const ChartOptions& options);

}  // namespace kerf
