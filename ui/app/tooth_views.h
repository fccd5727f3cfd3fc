// Views by the mouth: occlusal, buccal, lingual, mesial, distal; rows of the table in app_commands.cpp.
//
// They are of a place: the pixel of a script, else what is under the cursor, else the chosen piece, else what is in the
// middle of the view, else the part of the arch nearest to it. At that place the arch's curve (dental_arch.h) says
// which side is which; of a piece that was moved, where it was in the scan. Without a full arch a person tells: sides()
// and sidesHere(). Nothing is assumed: until then these views are refused, with what to do.
//
// The place comes to the middle of the picture, 24 mm from its lower to its upper edge, or less if the view was nearer
// already. The occlusal side is up; in the occlusal view the front of the arch is, or, as a person told, the buccal
// side. What stands in front is looked over: the lingual side is seen from 30 degrees above the occlusal plane, over
// the teeth of the other side, mesial and distal from 45, over those next to it, buccal from within the plane. Where a
// person told the sides it is one tooth, and all four are seen from within the plane.
#pragma once

#include "preprocess/close/dental_arch.h"
#include "ui/app/app_commands.h"

namespace kerf::tooth_views {

enum class ToothSide { kOcclusal, kBuccal, kLingual, kMesial, kDistal };

/// [X Y]. Errors: kBadValue for a pixel beside the object; kUnsupported: which side is which is not known.
Expected<void> look(AppContext& context, AppWords words, ToothSide side);
template <ToothSide kSide>
Expected<void> lookAt(AppContext& context, AppWords words) {
  return look(context, words, kSide);
}

/// BUCCAL MESIAL|auto: two axes of the scan. The occlusal side is the one of the two left that is up.
/// Error kBadValue: no axes, the same, or the third one is not the one that is up.
Expected<void> sides(AppContext& context, AppWords words);
/// left|right: this view is of the buccal side, with the mesial one to the left or right.
/// Error kUnsupported: it looks along the occlusal axis.
Expected<void> sidesHere(AppContext& context, AppWords words);
template <bool kMesialIsLeft>
Expected<void> thisIsBuccal(AppContext& context, AppWords) {
  const std::string words[] = {kMesialIsLeft ? "left" : "right"};
  return sidesHere(context, words);
}

}  // namespace kerf::tooth_views
