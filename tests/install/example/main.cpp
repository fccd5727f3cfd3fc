// example CASE: presses a bur into the object for a second, from z = 0 down, and prints the force and the removed
// volume.
#include <kerf/kerf.h>

#include <algorithm>
#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc != 2) return 2;
  const auto file = kerf::findToolFile("round-014", kerf::defaultToolFolders()).value();
  const kerf::Tool bur = kerf::readTool(file).value();
  const auto block = kerf::loadObject(argv[1]).value();

  kerf::Session session(kerf::makeModel({&bur, 1}).value(), {block}, {});
  kerf::StepOutput felt;
  double removed = 0, most = 0;
  for (int tick = 0; tick < 1000; ++tick) {
    kerf::DeviceSample hand;
    hand.T_world_device.translation.z() = -0.001 * tick;  // mm: 1 mm/s downwards
    hand.pedal = 1;
    session.tick(hand, felt);
    removed += felt.removed_mm3;
    most = std::max(most, felt.force.force.norm());
  }

  std::printf("removed %.3f mm3, felt %.2f N at most\n", removed, most);
  return removed > 0.05 && most > 0 ? 0 : 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
