#include "ui/window/frame/job_panel.h"

#include <imgui.h>

#include <cmath>

#include "ui/app/base/language.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {

void drawJob(AppContext& context) {
  const AnyJob* const job = context.bench.jobs->running();
  const ExportPlan& plan = *context.bench.exporting;
  if (!job || (plan.isShown() && plan.isBusy())) return;  // the export panel shows its own
  const JobStatus s = job->status();
  placeDialog(context, scaled(440));
  ui::begin("##job", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  ui::text(s.title);
  ui::progressBar(static_cast<float>(s.done), {-1, 0});
  std::string line = shownText(s.step);
  if (s.left_s) line += phrase("   about {:.0f} s left", std::ceil(*s.left_s));
  ui::textColored(styleColours().quiet, ui::asItIs(line));
  if (s.is_cancelling)
    ui::text("Cancelling...");
  else if (s.can_be_cancelled && ui::button("Cancel", {scaled(110), 0}))
    context.bench.jobs->cancel();
  ImGui::End();
}

}  // namespace kerf
