#include "ui/app/commands/point_commands.h"

#include <fmt/format.h>

#include <cstdio>

#include "geometry/base/text.h"
#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/workbench/point_readout.h"

namespace kerf::point_commands {
namespace {

Expected<PointReadout> pointed(const AppContext& c, AppWords words) {
  KERF_TRY(ray, pointedRay(c, words));
  const auto readout = readoutAt(c.bench, ray);
  if (!readout) return wrongWord("nothing is there", "a pixel of the object");
  return *readout;
}
void putOut(const AppContext& c, const std::string& text) {
  if (c.set_clipboard) return c.set_clipboard(text);
  printText("{}\n", text);
  std::fflush(stdout);
}

}  // namespace

bool hasMeasure(const AppContext& c) { return c.bench.isOpen() && !c.bench.measure.points().empty(); }

Expected<void> copyPoint(AppContext& c, AppWords words) {
  KERF_TRY(readout, pointed(c, words));
  putOut(c, textOf(readout));
  return {};
}

Expected<void> measurePoint(AppContext& c, AppWords words) {
  KERF_TRY(ray, pointedRay(c, words));
  const auto seen = c.bench.behindSection(ray);
  const auto hit = seen ? c.bench.scene().hit(*seen) : std::nullopt;
  if (!hit) return wrongWord("nothing is there", "a pixel of the object");
  c.bench.measure.add(hit->on_surface.point);
  return {};
}

Expected<void> copyMeasure(AppContext& c, AppWords) {
  putOut(c, c.bench.measure.text());
  return {};
}

Expected<void> clearMeasure(AppContext& c, AppWords) {
  c.bench.measure.clear();
  return {};
}

Expected<void> copyPathRow(AppContext& c, AppWords words) {
  KERF_TRY(readout, pointed(c, words));
  putOut(c, pathRowOf(readout));
  return {};
}

}  // namespace kerf::point_commands
