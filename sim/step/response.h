// Collision responses: how the tool is kept out of the tissue, and how the hand feels it. One row of a table each. The
// step, command lines, help texts and the benchmark read the table.
//
// penalty     A force that grows with the overlap: the default, and the subject of the goals. sim/step/contact.h.
// constraint  God-object (Zilles & Salisbury, IROS 1995; Ruspini, Kolarov & Khatib, SIGGRAPH 1997; in six degrees of
//             freedom: Ortega, Redon & Coquillart, TVCG 2007). The tool has no mass. Among the poses without overlap it
//             takes the one nearest to the device, in the metric of the coupling's stiffness, with the coupling's
//             damping when coupled. Contact points are gathered where the tool would go without contact, so that it
//             meets walls before it passes them.
// impulse     (Mirtich & Canny, I3D 1995; Baraff, SIGGRAPH 1989.) The tool is a body on the coupling. Contact points
//             that it would meet get impulses, until no point comes nearer than the skin within this evaluation, or
//             leaves more slowly than restitution requires.
//
// Constraint and impulse reduce the contact to a few points (sim/step/contact_points.h) and solve for the loads that
// hold them apart. The tool may overlap the tissue by a skin, contactSkin(): contact does not flicker, and erosion has
// something to remove. Overlap beyond the skin is reduced a part at a time, without load or velocity: otherwise walls
// on both sides would press without limit.
//
// Erosion and drag under constraint and impulse: the overlap gives places and proportions (the pressure of the penalty
// law), the solved load N gives the amount. Rates are scaled until the pressure, mean over the evaluation, integrates
// to N. Removal is then mu N v_s / u_s, as long as the overlap suffices; so a cutting part may overlap by up to 0.1 mm.
//
// To add a response: an enumerator, a function, a row in kResponses. Without the row the code does not compile.
#pragma once

#include <array>
#include <string_view>

#include "geometry/base/enumerator.h"

namespace kerf {

struct ContactEvaluation;
struct Model;
struct State;
struct Substep;

/// How the hand gets the force.
enum class Rendering {
  kCoupled,  ///< by the virtual coupling: the default
  kDirect,   ///< the force of contact itself: unstable when stiff. Attachment gives the tool's place
  kRigid     ///< no force: a machine leads the tool along its path at any force
};

/// The collision responses. Session logs keep the number.
enum class Response { kPenalty, kConstraint, kImpulse };

/// How the tool is tied to the device.
enum class Attachment {
  kFixed,  ///< the tool is where the device is
  kBody,   ///< the tool is a body with a mass on the springs and dampers of the coupling
  kProxy   ///< the same without a mass: it goes to the device unless something is in its way
};

/// The response laws: sums of contact, erosion and the tool's motion in one part of a tick. @rt
/// @cost  evaluatePenalty() tens to hundreds of microseconds, with the area in contact; the others twice that.
ContactEvaluation evaluatePenalty(const Model& model, State& state, const Substep& substep) noexcept;
ContactEvaluation evaluateConstraint(const Model& model, State& state, const Substep& substep) noexcept;
ContactEvaluation evaluateImpulse(const Model& model, State& state, const Substep& substep) noexcept;

/// All properties of one response.
struct ResponseRow {
  Response response;
  std::string_view name;         ///< in command lines and JSON
  std::string_view description;  ///< a phrase for help texts
  Attachment coupled;            ///< of the tool with Rendering::kCoupled
  Attachment direct;             ///< of the tool with Rendering::kDirect
  ContactEvaluation (*evaluate)(const Model&, State&, const Substep&) noexcept;

  /// Whether it goes with a rendering. A machine's tool is fixed: a response that needs a yielding tool cannot hold it
  /// back.
  constexpr bool fits(Rendering rendering) const {
    return rendering != Rendering::kRigid || direct == Attachment::kFixed;
  }
};

inline constexpr std::array kResponses = {
    ResponseRow{.response = Response::kPenalty,
                .name = "penalty",
                .description = "a force that grows with the overlap",
                .coupled = Attachment::kBody,
                .direct = Attachment::kFixed,
                .evaluate = evaluatePenalty},
    ResponseRow{.response = Response::kConstraint,
                .name = "constraint",
                .description = "god-object: the pose nearest to the device that does not overlap",
                .coupled = Attachment::kProxy,
                .direct = Attachment::kProxy,
                .evaluate = evaluateConstraint},
    ResponseRow{.response = Response::kImpulse,
                .name = "impulse",
                .description = "contact changes the velocity of a free body at once",
                .coupled = Attachment::kBody,
                .direct = Attachment::kBody,
                .evaluate = evaluateImpulse},
};
static_assert(hasRowForEach<kResponses, &ResponseRow::response>(), "every Response needs its row, in their order");

struct RenderingRow {
  Rendering rendering;
  std::string_view name;
};

inline constexpr std::array kRenderings = {
    RenderingRow{Rendering::kCoupled, "coupled"},
    RenderingRow{Rendering::kDirect, "direct"},
    RenderingRow{Rendering::kRigid, "rigid"},
};
static_assert(hasRowForEach<kRenderings, &RenderingRow::rendering>(), "every Rendering needs its row, in their order");

/// Whether a number from a file is valid.
constexpr bool isKnown(Response response) { return static_cast<std::size_t>(response) < kResponses.size(); }
constexpr bool isKnown(Rendering rendering) { return static_cast<std::size_t>(rendering) < kRenderings.size(); }

/// @pre isKnown(). @rt
constexpr const ResponseRow& rowOf(Response response) { return kResponses[static_cast<std::size_t>(response)]; }

/// The row of that name; null: none.
constexpr const ResponseRow* findResponse(std::string_view name) {
  for (const ResponseRow& row : kResponses)
    if (row.name == name) return &row;
  return nullptr;
}

}  // namespace kerf
