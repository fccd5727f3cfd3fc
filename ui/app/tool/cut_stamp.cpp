#include "ui/app/tool/cut_stamp.h"

namespace kerf {

bool CutStamp::Object::operator==(const Object& other) const {
  return id == other.id && name == other.name && T_world_object.translation == other.T_world_object.translation &&
         T_world_object.rotation.coeffs() == other.T_world_object.rotation.coeffs();
}

CutStamp cutStampOf(std::uint64_t generation, const HapticReport& report, const LiveScene& scene) {
  CutStamp out;
  out.generation = generation;
  out.edits = report.counts.edits_pushed + report.counts.edits_waiting;
  for (std::size_t n = 0; n < report.object_count; ++n) {
    const ObjectReport& object = report.objects[n];
    const SceneObject* const shown = scene.find(object.id);
    out.objects.push_back({object.id, object.T_world_object, shown ? shown->name : std::string()});
  }
  return out;
}

}  // namespace kerf
