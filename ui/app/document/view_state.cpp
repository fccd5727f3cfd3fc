#include "ui/app/document/view_state.h"

#include <utility>

#include "sim/run/session/watched_run.h"

namespace kerf {

std::optional<Ray> ViewState::behindSection(const Ray& ray) const {
  if (!section || section->height(ray.origin) <= 0) return ray;
  const double falls = -section->normal.dot(ray.direction);
  if (falls < 1e-6) return {};  // it never comes out
  const Ray out{ray.at(section->height(ray.origin) / falls), ray.direction};

  for (const SceneObject* object : document_.scene().shown()) {
    if (object->is_hidden) continue;
    // The ray enters a surface as often as it leaves it, unless it begins inside.
    const Ray local = inFrame(object->pose(), out);
    const auto in = object->surface.hit(local);
    const auto leaves = object->surface.exit(local, 0);
    if (leaves && (!in || *leaves < in->way)) return {};
  }
  return out;
}

void ViewState::opened(Opening how) {
  TissueSource source = document_.run() ? tissueSourceOf(*document_.run(), document_.sharedStructures())
                                        : tissueSourceOf(*document_.watched());
  if (document_.run()) source.beside_fields = document_.neighbourFields();
  tissues_.opened(std::move(source), document_.materials());
  if (how == Opening::kReopened) return;
  section.reset();
  measure.clear();
  told_sides.reset();
}

void ViewState::closing() { tissues_.closing(); }

void ViewState::update() {
  if (const auto done = tissues_.update(); !done) notices_.complain(done.error());
}

}  // namespace kerf
