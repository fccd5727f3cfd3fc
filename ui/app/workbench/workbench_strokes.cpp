// Strokes by mouse: tool pose, commands, distance to protected structures. The rest of the workbench: workbench.cpp.
#include <algorithm>
#include <utility>

#include "ui/app/import/import_set.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

std::optional<Ray> Workbench::behindSection(const Ray& ray) const {
  if (!section || section->height(ray.origin) <= 0) return ray;
  const double falls = -section->normal.dot(ray.direction);
  if (falls < 1e-6) return {};  // it never comes out
  const Ray out{ray.at(section->height(ray.origin) / falls), ray.direction};

  for (const SceneObject* object : scene_.shown()) {
    if (object->is_hidden) continue;
    // The ray enters a surface as often as it leaves it, unless it begins inside.
    const Ray local = inFrame(object->pose(), out);
    const auto in = object->surface.hit(local);
    const auto leaves = object->surface.exit(local, 0);
    if (leaves && (!in || *leaves < in->way)) return {};
  }
  return out;
}

std::optional<ToolOverSurface> Workbench::over(const Ray& ray) const {
  if (!run_) return {};
  const auto seen = behindSection(ray);
  if (!seen) return {};
  if (saw_->isGuiding()) return saw_->over(*seen);
  auto at = toolOver(scene_, *run_->original(), *seen, plunges_[tool_]);
  if (at) tiltTool(*at, tilt, touches_[tool_]);
  return at;
}

bool Workbench::press(const Ray& ray) {
  if (import_ || saw_->isCutting() || undos_left_ != 0 || wish_) return false;  // a session behind an import rests
  if (isLed()) {
    warnThatItIsLed();
    return false;
  }
  const auto at = over(ray);
  if (!at) {
    const auto seen = behindSection(ray);
    if (const auto hit = seen ? scene_.hit(*seen) : std::nullopt) (void)isNeighbour(hit->id, "to be cut");
    return false;
  }
  release();
  pointed_ = ray;
  // A mouse cannot be jerked like an arm: after a late clock it continues at once.
  if (report_.is_latched) send(ClearLatch{});
  const bool is_guided = saw_->isGuiding();
  aim_.guide = is_guided ? saw_->plan().chosen()->normal : Vec3d(Vec3d::Zero());
  stroke_.emplace(*run_->original(), *at, heads_[tool_]);
  stroke_->begin(aim_);
  aim_.samples = structures_->isEmpty() && neighbour_fields_.empty() ? nullptr : &samplesOf(tool_);
  sendAim();

  const Rigid3& start = stroke_->start();
  const Eigen::Quaterniond& q = start.rotation;
  send(PlaceTool{{start.translation[0], start.translation[1], start.translation[2]}, {q.w(), q.x(), q.y(), q.z()}});
  return true;
}

void Workbench::drag(const Ray& ray) {
  if (!stroke_) return;
  pointed_ = ray;
  aim_.pointer = stroke_->pointerOf(ray);
  sendAim();
}

void Workbench::deepen(double mm) {
  depth_mm = std::clamp(depth_mm + mm, 0.0, mostDepth());
  along_.reset();
  if (stroke_) sendAim();
}

double Workbench::mostDepth() const { return saw_->isGuiding() ? saw_->plan().chosen()->depth : kMostDepth; }

void Workbench::setForce(double newtons) {
  force = std::clamp(newtons, kLeastForce, kMostForce);
  if (stroke_) sendAim();
}

void Workbench::pushHarder(double factor) {
  push_factor_ = factor;
  if (stroke_) sendAim();
}

void Workbench::release() {
  if (!stroke_) return;
  stroke_.reset();
  along_.reset();
  is_on_pedal_ = false;
  drill_ = 1;
  aim_.is_pressed = false;
  sendAim();
}

void Workbench::sendAim() {
  aim_.force = std::min(force * push_factor_, kMostForce);
  aim_.depth = std::min({depth_mm, mostDepth(), along_.value_or(depth_mm)});
  aim_.pedal = (is_reversed_ ? -1 : 1) * speed * drill_;
  aim_.irrigation = irrigation;
  aim_.keep = stop_short_mm.value_or(-1);
  aim_.keep_beside = stop_short_beside_mm.value_or(-1);
  hand_->aim(aim_);
}

std::optional<double> Workbench::depthNow() const {
  if (!stroke_) return {};
  return stroke_->depthOf(report_.output.T_world_tool.translation);
}

std::optional<ToolFront> Workbench::toolFront() const {
  if (!run_ || (!stroke_ && !isLed() && !saw_->isCutting())) return {};
  const Rigid3 T_object_world = (stroke_ ? aim_.T_world_surface : report_.objects[0].T_world_object).inverse();
  const Rigid3 tool = T_object_world * report_.output.T_world_tool;
  const Plunge& plunge = plunges_[tool_];
  ToolFront out{tool * Vec3d(plunge.reach * plunge.direction), tool.rotation * plunge.direction};
  const auto depth = depthBelow(*run_->original(), out.point, -out.into);
  if (!depth) return {};
  out.depth = *depth;
  return out;
}

std::optional<double> Workbench::tipDepth() const {
  const auto front = toolFront();
  return front ? std::optional(front->depth) : std::nullopt;
}

void Workbench::stopShort(std::optional<double> mm) {
  stop_short_mm = mm;
  if (stroke_) sendAim();
}

// From now on the report gives the heating by this tool.
void Workbench::heatByToolInHand() { run_->thread().heatBy(tool_, samplesOf(tool_), heatSource(tool(tool_))); }

const ToolSamples& Workbench::samplesOf(std::size_t tool) const {
  const auto known = samples_.find(tool);
  if (known != samples_.end()) return known->second;
  return samples_.emplace(tool, ToolSamples(run_->model().tools[tool].cut, kToolSamples)).first->second;
}

std::optional<NearStructure> Workbench::nearStructure(const std::optional<ToolOverSurface>& over) const {
  constexpr double kStopped = 0.03;  // mm: the closest approach of a held button to its limit
  if (!run_ || structures_->isEmpty() || (!stroke_ && !over && !isLed())) return {};
  const Rigid3 tool = stroke_ || isLed() ? report_.output.T_world_tool : over->T_world_tool;
  const Rigid3 object = stroke_   ? aim_.T_world_surface
                        : isLed() ? report_.objects[0].T_world_object
                                  : over->T_world_object;
  const Structures::Nearest nearest = structures_->nearest(samplesOf(tool_), object.inverse() * tool);

  NearStructure out;
  out.name = nameOf(structures_->all()[nearest.structure].material);
  out.distance_mm = nearest.reading.distance;
  out.is_far = nearest.reading.is_far;
  out.is_stopped = stroke_ && stop_short_mm && !out.is_far && out.distance_mm <= *stop_short_mm + kStopped;
  return out;
}

}  // namespace kerf
