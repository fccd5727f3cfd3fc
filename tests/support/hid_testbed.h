// HID devices that are not there: nodes and sysfs by umockdev, under the unmodified hidapi of the system. The program
// has to run with umockdev's library preloaded; isThere() tells.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace kerf {

using Bytes = std::vector<std::uint8_t>;

struct SimulatedHid {
  std::uint16_t vendor = 0x046d, product = 0xc626;
  std::string maker = "3Dconnexion", name = "SpaceNavigator", serial = {};
  /// Usage of each interface, page and usage: one node each.
  std::vector<std::pair<int, int>> interfaces = {{1, 8}};
  int port = 1;  ///< of the USB hub: no two may share one
  int first_node = 0;
};

class HidTestbed {
 public:
  static bool isThere();
  HidTestbed();
  ~HidTestbed();
  HidTestbed(const HidTestbed&) = delete;
  HidTestbed& operator=(const HidTestbed&) = delete;

  void plugIn(const SimulatedHid& what);
  /// Reads and writes fail, then the nodes are gone.
  void unplug(const SimulatedHid& what);
  /// A report the device sends. The system keeps them in order, each by itself.
  void send(int node, const Bytes& report);
  /// The same of a device that never stops: where 64 wait it is lost, as in the system.
  void stream(int node, const Bytes& report);
  /// What was written to the node so far.
  std::vector<Bytes> written(int node) const;
  static std::string path(int node) { return "/dev/hidraw" + std::to_string(node); }
  Bytes lastWritten(int node) const;  ///< empty: nothing
  void forgetWritten(int node);
  /// Writes to the node from now on take until it is called with false: only then they are written, in their order.
  void holdWrites(int node, bool are_held);
  /// Writes that are being held.
  std::size_t heldWrites(int node) const;
  /// What was written since it was asked last; written() and lastWritten() know nothing of it any more.
  std::vector<Bytes> takeWritten(int node);
  /// Who is not the owner of its files may list devices, as on a real system.
  void letOthersLook();
  /// Told of each report that was taken, by a thread of the testbed.
  void listen(int node, std::function<void(const Bytes&)> heard);
  /// Where its files are in truth: to take a permission away.
  std::string realPath(int node) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
