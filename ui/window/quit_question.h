// The question before the window closes on a cut that was not exported.
#pragma once

#include "ui/app/app_commands.h"

namespace kerf {

/// Nothing while nothing is asked: AppContext::is_asking_to_quit.
void drawQuitQuestion(AppContext& context);

/// Enter exports, Escape stays.   @return  false: nothing is asked.
bool quitQuestionKey(AppContext& context, bool is_enter);

}  // namespace kerf
