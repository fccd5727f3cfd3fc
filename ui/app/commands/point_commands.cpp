#include "ui/app/commands/command_tables.h"

#include <fmt/format.h>

#include <cstdio>

#include "geometry/base/text.h"
#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/document/view_state.h"
#include "ui/app/readout/point_readout.h"

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

bool hasMeasure(const AppContext& c) { return c.bench.document->isOpen() && !c.bench.views->measure.points().empty(); }

Expected<void> copyPoint(AppContext& c, AppWords words) {
  KERF_TRY(readout, pointed(c, words));
  putOut(c, textOf(readout));
  return {};
}

Expected<void> measurePoint(AppContext& c, AppWords words) {
  KERF_TRY(ray, pointedRay(c, words));
  const auto seen = c.bench.views->behindSection(ray);
  const auto hit = seen ? c.bench.document->scene().hit(*seen) : std::nullopt;
  if (!hit) return wrongWord("nothing is there", "a pixel of the object");
  c.bench.views->measure.add(hit->on_surface.point);
  return {};
}

Expected<void> copyMeasure(AppContext& c, AppWords) {
  putOut(c, c.bench.views->measure.text());
  return {};
}

Expected<void> clearMeasure(AppContext& c, AppWords) {
  c.bench.views->measure.clear();
  return {};
}

Expected<void> copyPathRow(AppContext& c, AppWords words) {
  KERF_TRY(readout, pointed(c, words));
  putOut(c, pathRowOf(readout));
  return {};
}

constexpr AppCommand kRows[] = {
    {"point.copy", "Edit:3", "Copy point under cursor", "Ctrl+C", "[X Y]",
     "Copies point, normal, tissue and thickness along the viewing direction as text, in the frame of the scan.",
     when::isOpen, copyPoint},
    {"point.copy-row", "Edit:3", "Copy point as path row", "Ctrl+Shift+C", "[X Y]",
     "Copies the tool pose at the point as a row of a path: t,x,y,z,qw,qx,qy,qz.", when::isOpen, copyPathRow},
    {"measure.point", "Edit:3", "Measure from here", "M", "[X Y]",
     "Sets a measuring point on the surface. The window shows distances between points and angles at them.",
     when::isOpen, measurePoint},
    {"measure.copy", "Edit:3", "Copy measurements", "", "", "Copies distances and angles as text.", hasMeasure,
     copyMeasure},
    {"measure.clear", "Edit:3", "Clear measurements", "Shift+M", "", "Removes all measuring points.", hasMeasure,
     clearMeasure},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::point_commands
