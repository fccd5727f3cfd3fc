// Simulated HID devices: nodes and sysfs by umockdev, under the unmodified hidapi of the system. The program must run
// with umockdev's library preloaded; isThere() checks this.
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
  int port = 1;  ///< of the USB hub, unique
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
  /// A report from the device. The system keeps reports in order, separately.
  void send(int node, const Bytes& report);
  /// A report from a device that never stops: discarded if 64 wait, as in the system.
  void stream(int node, const Bytes& report);
  /// All data written to the node so far.
  std::vector<Bytes> written(int node) const;
  static std::string path(int node) { return "/dev/hidraw" + std::to_string(node); }
  Bytes lastWritten(int node) const;  ///< empty: nothing
  void forgetWritten(int node);
  /// Holds back writes to the node until it is called with false. Then they are written in order.
  void holdWrites(int node, bool are_held);
  /// Number of writes held back.
  std::size_t heldWrites(int node) const;
  /// Data written since the last call, which removes it from written() and lastWritten().
  std::vector<Bytes> takeWritten(int node);
  /// Other users than the owner of its files may list devices, as on a real system.
  void letOthersLook();
  /// Called for each accepted report, on a thread of the testbed.
  void listen(int node, std::function<void(const Bytes&)> heard);
  /// Real place of its files, for tests that remove a permission.
  std::string realPath(int node) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
