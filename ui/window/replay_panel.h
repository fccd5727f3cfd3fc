// The panels of a session that is watched: a scrub bar with its steps below, what was felt and cut at the right. And
// the question what to do with a run: go on with it, or watch it.
#pragma once

#include "ui/app/app_commands.h"

namespace kerf {

void drawReplay(AppContext& context);
/// Nothing, unless somebody has opened a run.
void drawRunQuestion(AppContext& context);

}  // namespace kerf
