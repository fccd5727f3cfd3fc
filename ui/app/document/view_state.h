// Choices about the view of the open document: section, measured points, tooth sides, tissues and colours. No OpenGL.
#pragma once

#include <memory>
#include <optional>

#include "ui/app/document/document.h"
#include "ui/app/view/measure.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/view/upright.h"

namespace kerf {

class ViewState final : public Part {
 public:
  ViewState(Notices& notices, Document& document) : notices_(notices), document_(document) {}

  Measure measure;
  /// Hides the side its normal points to from view and pointing. None: shows all.
  std::optional<Plane> section;
  /// Tooth sides set by the user, in the scan's frame. They override Document::occlusal() until another document is
  /// open. None: not set.
  std::optional<ToothSides> told_sides;

  /// The ray from its exit out of the hidden side of the section. None: that point is inside an object.
  std::optional<Ray> behindSection(const Ray& ray) const;

  TissueDisplay& tissues() { return tissues_; }
  const TissueDisplay& tissues() const { return tissues_; }

  void opened(Opening how) override;
  void closing() override;
  void update() override;

 private:
  Notices& notices_;
  Document& document_;
  TissueDisplay tissues_;
};

}  // namespace kerf
