#include "ui/app/import/trim_drawing.h"

#include <utility>

#include "ui/app/base/language.h"

namespace kerf {
namespace {

constexpr double kStep = 3, kShortest = 12;  // pixels: between corners of a lasso; of a whole line

}  // namespace

void TrimDrawing::begin(What what) {
  what_ = what;
  points_.clear();
}

std::string TrimDrawing::hint() const {
  switch (what_) {
    case What::kNothing:
      break;
    case What::kLasso:
      return shownText("Hold the left button and draw around the part to remove. Esc ends.");
    case What::kLine:
      return shownText("Drag the left button across the scan. The smaller part goes. Esc ends.");
  }
  return {};
}

void TrimDrawing::press(const Pixel& at) {
  if (what_ != What::kNothing) points_ = {at};
}

void TrimDrawing::move(const Pixel& at) {
  if (points_.empty()) return;
  if (what_ == What::kLine)
    points_ = {points_.front(), at};
  else if ((at - points_.back()).norm() >= kStep)
    points_.push_back(at);
}

std::vector<Pixel> TrimDrawing::release() {
  std::vector<Pixel> drawn = std::exchange(points_, {});
  double length = 0;
  for (std::size_t n = 1; n < drawn.size(); ++n) length += (drawn[n] - drawn[n - 1]).norm();
  const std::size_t least = what_ == What::kLine ? 2 : 3;
  if (drawn.size() < least || length < kShortest) drawn.clear();
  return drawn;
}

}  // namespace kerf
