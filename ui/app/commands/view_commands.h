// Commands of the view: named views, zoom, sections, pictures; rows of the table in app_commands.cpp.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// First view of a newly opened document: `otherwise`, with the occlusal side up if there is one. From above looks
/// perpendicular to that side.
void firstView(AppContext& context, const Camera& otherwise);

}  // namespace kerf

namespace kerf::view_commands {

bool hasSection(const AppContext& context);

Expected<void> fit(AppContext& context, AppWords words);
Expected<void> view(AppContext& context, AppWords words);  ///< NAME|AZ,EL
Expected<void> up(AppContext& context, AppWords words);    ///< AXIS|auto
template <std::size_t N>
Expected<void> namedView(AppContext& context, AppWords) {
  const std::string words[] = {std::string(namedViews()[N].name)};
  return view(context, words);
}
Expected<void> zoom(AppContext& context, AppWords words);         ///< FACTOR [X Y]
Expected<void> perspective(AppContext& context, AppWords words);  ///< [DEG|off]
Expected<void> roll(AppContext& context, AppWords words);         ///< [DEG]
bool isRolled(const AppContext& context);
Expected<void> level(AppContext& context, AppWords words);

Expected<void> cutOpen(AppContext& context, AppWords words);        ///< [X Y]
Expected<void> sectionDeeper(AppContext& context, AppWords words);  ///< [MM]
Expected<void> sectionNearer(AppContext& context, AppWords words);  ///< [MM]

Expected<void> plots(AppContext& context, AppWords words);  ///< [on|off]

Expected<void> screenshot(AppContext& context, AppWords words);  ///< OUT.png

}  // namespace kerf::view_commands
