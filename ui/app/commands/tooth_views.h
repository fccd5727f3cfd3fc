// Dental views: occlusal, buccal, lingual, mesial, distal; rows of the table in app_commands.cpp.
//
// Each view shows a place: a script's pixel, else the point under the cursor, else the chosen piece, else the middle of
// the view, else the nearest part of the arch. The arch's curve (dental_arch.h) gives the sides there; for a moved
// piece, at its place in the scan. Without a full arch the user sets the sides: sides() and sidesHere(). Until then
// these views give an error with a remedy.
//
// The place comes to the middle of the picture, 24 mm from lower to upper edge, or less if the view was nearer. The
// occlusal side is up; in the occlusal view, the front of the arch, or the buccal side if the user set the sides. The
// view looks over obstacles: lingual from 30 degrees above the occlusal plane, over the teeth of the other side; mesial
// and distal from 45, over the adjacent teeth; buccal from within the plane. If the user set the sides, it is one
// tooth, and all four look from within the plane.
#pragma once

#include "preprocess/close/dental_arch.h"
#include "ui/app/commands/app_commands.h"

namespace kerf::tooth_views {

enum class ToothSide { kOcclusal, kBuccal, kLingual, kMesial, kDistal };

/// [X Y]. Errors: kBadValue for a pixel beside the object; kUnsupported: unknown sides.
Expected<void> look(AppContext& context, AppWords words, ToothSide side);
template <ToothSide kSide>
Expected<void> lookAt(AppContext& context, AppWords words) {
  return look(context, words, kSide);
}

/// BUCCAL MESIAL|auto: two axes of the scan. Of the remaining two directions, the one that is up is the occlusal side.
/// Error kBadValue: no axes, the same, or the third one is not the one that is up.
Expected<void> sides(AppContext& context, AppWords words);
/// left|right: this view shows the buccal side, with the mesial one to the left or right.
/// Error kUnsupported: it looks along the occlusal axis.
Expected<void> sidesHere(AppContext& context, AppWords words);
template <bool kMesialIsLeft>
Expected<void> thisIsBuccal(AppContext& context, AppWords) {
  const std::string words[] = {kMesialIsLeft ? "left" : "right"};
  return sidesHere(context, words);
}

}  // namespace kerf::tooth_views
