#include "ui/window/panels/plots_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include "ui/app/base/language.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

void drawPlot(const Trace& trace, const Trace::About& channel) {
  const double top = trace.scaleTop(channel);
  const float newest = trace.newest(channel.channel);
  ui::textColored(styleColours().quiet, channel.name);
  ui::sameLineAt(scaled(118));
  ui::text(shownNumbers("{:.2f} {}", newest, shownText(channel.unit)));
  const std::string scale = phrase("0 to {:g}", top);
  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - ui::textSize(scale).x);
  ui::textColored(styleColours().quiet, scale);

  const std::string label = fmt::format("##{}", channel.name);
  ImGui::PlotLines(label.c_str(), trace.values(channel.channel).data(), static_cast<int>(Trace::kCount),
                   static_cast<int>(trace.oldest()), nullptr, 0, static_cast<float>(top),
                   {ImGui::GetContentRegionAvail().x, scaled(20)});
}

}  // namespace

void drawPlots(PanelFrame& frame) {
  const Trace& trace = frame.context.bench.monitor->trace();
  for (const Trace::About& channel : Trace::kChannels) drawPlot(trace, channel);
}

}  // namespace kerf
