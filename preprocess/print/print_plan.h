// The print plan: steps that make a solid ready for a printer, as a TOML file to repeat on many models.
//
//   format = "kerf-print"
//   version = 1
//   up = [0, 0, 1]                 # from the build plate into the model; default: its flat base stands on the plate
//   to_bed = "Form 3"              # lays the result on the bed of a printer (print/beds.toml) or of a size, such as
//                                  # "145x145x185"; default: the frame of the scan stays
//
//   [[step]]
//   do = "hollow"
//   wall = 2                       # mm
//   rounding = 0.3                 # mm, radius of the cavity's edges
//   least_cavity = 30              # mm3; smaller ones stay full
//   voxel = 0.15                   # mm; default: a twelfth of the wall
//
//   [[step]]
//   do = "drain"                   # round holes into the cavities
//   diameter = 3.5                 # mm
//   count = 2                      # for each cavity
//   side = "underside"             # or "nearest": the nearest wall
//   at = [[10, 5, 0]]              # places by hand, mm; optional
//
//   [[step]]
//   do = "label"
//   text = "{case} {date}"         # {case}, {date}, and the words of kerf prepare --word
//   on = "underside"               # or "side"
//   height = 4                     # mm, of a capital letter
//   depth = 0.6                    # mm
//   embossed = false
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"
#include "preprocess/print/drain.h"
#include "preprocess/print/hollow.h"
#include "preprocess/print/label.h"

namespace kerf {

struct LabelStep {
  LabelFace face = LabelFace::kUnderside;
  LabelOptions label;  ///< text with placeholders; the place is found on the model
};

using PrintStep = std::variant<HollowOptions, DrainOptions, LabelStep>;

struct PrintPlan {
  std::optional<Vec3d> up;  ///< unit; empty: opposite to the flat base
  std::string to_bed;       ///< words of printBedOf(); empty: the frame stays
  std::vector<PrintStep> steps;
};

/// Strict: an unknown key or step, or a number out of range, is an error that names line and key.
Expected<PrintPlan> readPrintPlan(const std::filesystem::path& file);

}  // namespace kerf
