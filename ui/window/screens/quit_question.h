// The dialog before the window closes on a cut that was not exported.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Draws nothing unless AppContext::is_asking_to_quit.
void drawQuitQuestion(AppContext& context);

/// Enter exports, Escape stays.   @return  false: no open question.
bool quitQuestionKey(AppContext& context, bool is_enter);

}  // namespace kerf
