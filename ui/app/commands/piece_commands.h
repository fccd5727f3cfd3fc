// Commands that move, name, hide and export pieces; rows of the table in app_commands.cpp.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf::piece_commands {

/// There are several pieces, or one was moved.
bool arePieces(const AppContext& context);
bool isChosen(const AppContext& context);

Expected<void> choose(AppContext& context, AppWords words);  ///< PIECE: name or number
Expected<void> chooseNext(AppContext& context, AppWords words);
Expected<void> move(AppContext& context, AppWords words);  ///< X Y Z, mm, relative
Expected<void> turn(AppContext& context, AppWords words);  ///< X|Y|Z DEGREES, about its middle
Expected<void> putBack(AppContext& context, AppWords words);
Expected<void> hide(AppContext& context, AppWords words);
Expected<void> show(AppContext& context, AppWords words);    ///< all
Expected<void> rename(AppContext& context, AppWords words);  ///< NAME
Expected<void> colour(AppContext& context, AppWords words);  ///< [COLOUR|none]
Expected<void> exportEach(AppContext& context, AppWords words);
Expected<void> exportChosen(AppContext& context, AppWords words);
Expected<void> exportPutBack(AppContext& context, AppWords words);

}  // namespace kerf::piece_commands
