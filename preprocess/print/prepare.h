// Runs a print plan: a closed solid in, a solid ready for a printer out, with the numbers of each step.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"
#include "preprocess/print/pockets.h"
#include "preprocess/print/print_bed.h"
#include "preprocess/print/print_plan.h"

namespace kerf {

/// Result of one step, for a report.
struct StepReport {
  std::string step;                       ///< "hollow", "drain", "label"
  std::string summary;                    ///< a sentence
  std::map<std::string, double> numbers;  ///< by name and unit: "wall_least_mm"
  std::vector<std::string> warnings;      ///< sentences
};

struct Prepared {
  Mesh mesh;  ///< float32-representable; surviving vertices of the source bit for bit until the bed
  std::size_t source_vertices_kept = 0;  ///< before the bed
  std::vector<LaidPiece> laid;           ///< on a bed: `mesh`, `up` and `pockets` are in its frame
  Vec3d up = Vec3d::UnitZ();             ///< unit, from the build plate into the model
  bool on_plate = false;                 ///< a flat base stands on the plate
  double source_mm3 = 0, resin_mm3 = 0;
  std::vector<StepReport> steps;
  Pockets pockets;  ///< of the result: trapped resin and suction cups
};

/// Checks the texts of the labels, runs the steps in their order on the source without unused vertices, then checks the
/// whole as it is printed and searches for pockets.
/// @param words  for the placeholders of labels: "case", "date", "tooth".
/// Guarantees: the result is print-ready by checkMesh(). Errors: those of the steps, with the number of the step;
/// kGeometry if the model has no flat base and the plan no `up`.
/// @pre  print-ready by checkMesh(); mm.   @cost  sum of the steps. @thread any; deterministic.
Expected<Prepared> prepareForPrint(const Mesh& source, const PrintPlan& plan,
                                   const std::map<std::string, std::string>& words, const Progress& progress = {});

}  // namespace kerf
