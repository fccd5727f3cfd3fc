#include "ui/app/workbench/die_making.h"

#include <fmt/format.h>

#include <algorithm>

#include "geometry/case/case_bundle.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

struct DieNumber {
  const char* name;
  double DieChoice::*value;
  double least, most;
  bool plans_anew;
};
constexpr DieNumber kNumbers[] = {
    {"taper", &DieChoice::taper_deg, 0, DieChoice::kMostTaper, true},
    {"base", &DieChoice::base_mm, 0, DieChoice::kMostBase, true},
    {"kerf", &DieChoice::kerf_mm, 0, CutPlanes::kMostKerf, false},
    {"pin", &DieChoice::pin_mm, 0, DieChoice::kMostPin, false},
    {"pin-depth", &DieChoice::pin_depth_mm, 0.5, DieChoice::kMostPinDepth, false},
};

}  // namespace

std::string DieMaking::names() {
  std::string out;
  for (const DieNumber& number : kNumbers) out += fmt::format("{}, ", number.name);
  return out + "sides";
}

Expected<void> DieMaking::set(const std::string& name, double value) {
  const DieChoice before = choice_;
  bool plans_anew = name == "sides";
  if (name == "sides") {
    if (value != 2 && value != 4)
      return fail(
          {.code = Error::Code::kBadValue, .found = fmt::format("{:g} sides", value), .expected = "2 (the ends) or 4"});
    choice_.has_four_sides = value == 4;
  } else {
    const auto* const number =
        std::find_if(std::begin(kNumbers), std::end(kNumbers), [&](const DieNumber& one) { return name == one.name; });
    if (number == std::end(kNumbers))
      return fail({.code = Error::Code::kBadValue, .found = "\"" + name + "\"", .expected = "one of " + names()});
    const bool is_no_pin = value == 0 && number->value == &DieChoice::pin_mm;
    const double least = number->value == &DieChoice::pin_mm && !is_no_pin ? RoundHole::kLeastDiameter : number->least;
    if (!(value >= least && value <= number->most))
      return fail({.code = Error::Code::kBadValue,
                   .place = name,
                   .found = fmt::format("{:g}", value),
                   .expected = fmt::format("{:g} to {:g}", least, number->most)});
    choice_.*number->value = value;
    plans_anew = number->plans_anew;
  }
  if (!place_ || !plans_anew || choice_ == before) return {};
  auto planned = planHere();
  if (!planned) choice_ = before;
  return planned;
}

Expected<void> DieMaking::plan(const Ray& ray) {
  KERF_CHECK(bench_.saw->hit(ray));
  const auto hit = bench_.document->scene().hit(ray);
  const SceneObject* const piece = bench_.document->scene().find(hit->id);
  if (piece && (piece->isMoved() || piece->isBeside()))
    return fail({.code = Error::Code::kUnsupported,
                 .found = piece->isBeside() ? "a neighbour" : "a moved piece",
                 .expected = "a tooth of the scan, at its place",
                 .hint = piece->isBeside() ? "open that scan by itself" : "put the piece back (piece.put-back)"});
  place_ = Place{hit->on_surface.point, hit->id, Vec3d::UnitZ()};
  return planHere();
}

Expected<void> DieMaking::planHere() {
  KERF_TRY(solid, readCaseSolid(bench_.document->run()->caseFolder()));
  KERF_TRY(made, planDie(place_->at, bench_.document->occlusal(), solid, *bench_.document->run()->original(), choice_));
  SawPlan& plan = bench_.saw->plan();
  for (const std::string& name : names_)
    if (plan.choose(name)) plan.removeChosen();
  names_.clear();
  place_->occlusal = made.frame.sides.occlusal;
  for (SawPlane& plane : made.planes) {
    plane.name = shownText(plane.name);
    plan.add(std::move(plane));
    names_.push_back(plan.chosen()->name);
  }
  KERF_CHECK(plan.choose(names_.front()));

  // A usual pin may be too long for a low model: then the longest that fits.
  if (const auto& hole = pin(); !hole && choice_.pin_mm > 0) {
    DieChoice shorter = choice_;
    while (shorter.pin_depth_mm > 2 &&
           !pinOf(planes(), place_->occlusal, place_->at, *bench_.document->run()->original(), shorter))
      shorter.pin_depth_mm -= 0.5;
    if (!pinOf(planes(), place_->occlusal, place_->at, *bench_.document->run()->original(), shorter)) return {};
    bench_.notices->say(phrase("Pin hole shortened from {:.1f} to {:.1f} mm: the tooth is low", choice_.pin_depth_mm,
                               shorter.pin_depth_mm));
    choice_ = shorter;
  }
  return {};
}

std::vector<SawPlane> DieMaking::planes() const {
  std::vector<SawPlane> out;
  for (const SawPlane& plane : bench_.saw->plan().planes())
    if (std::find(names_.begin(), names_.end(), plane.name) != names_.end()) out.push_back(plane);
  return out;
}

const Expected<std::optional<RoundHole>>& DieMaking::pin() const {
  const std::uint64_t version = bench_.saw->plan().version();
  if (pin_.version == version && pin_.choice == choice_) return pin_.hole;
  pin_.version = version;
  pin_.choice = choice_;
  pin_.hole = std::optional<RoundHole>{};
  if (choice_.pin_mm == 0 || !place_ || !isPlanned()) return pin_.hole;
  auto hole = pinOf(planes(), place_->occlusal, place_->at, *bench_.document->run()->original(), choice_);
  if (hole)
    pin_.hole = std::optional(*hole);
  else
    pin_.hole = fail(std::move(hole).error());
  return pin_.hole;
}

Expected<void> DieMaking::cut() {
  if (!place_ || !isPlanned())
    return fail({.code = Error::Code::kEmpty,
                 .found = "no planned die",
                 .expected = "planes around a tooth",
                 .hint = "click a tooth: plane.die X Y"});
  if (!pin()) return fail(pin().error());
  CutPlanes cut;
  cut.kerf_mm = choice_.kerf_mm;
  for (const SawPlane& plane : planes()) cut.add({plane.point, plane.normal});
  if (const auto& hole = *pin()) cut.setHole(*hole);
  return bench_.saw->cutAtOnce(PlaneKeep::kBoth, cut, shownText("Die"), place_->piece);
}

void DieMaking::clear() {
  place_.reset();
  names_.clear();
  pin_ = {};
}

}  // namespace kerf
