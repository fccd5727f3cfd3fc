#include "tests/support/hid_testbed.h"

#include <fmt/format.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <utility>

namespace kerf {
namespace {

// One application collection of that usage, sufficient for hidapi.
Bytes descriptorOf(int page, int usage) {
  const auto low = [](int n) { return static_cast<std::uint8_t>(n & 255); };
  const auto high = [](int n) { return static_cast<std::uint8_t>(n >> 8); };
  if (page > 255) return {0x06, low(page), high(page), 0x0A, low(usage), high(usage), 0xA1, 0x01, 0xC0};
  return {0x05, low(page), 0x09, low(usage), 0xA1, 0x01, 0xC0};
}

std::string hex(const Bytes& bytes) {
  std::string out;
  for (const std::uint8_t b : bytes) out += fmt::format("{:02X}", b);
  return out;
}

void check(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "the testbed failed: %s\n", what);
  std::abort();
}

}  // namespace

// A node is a pseudo-terminal. A byte in it makes poll() report data; the data itself comes from the queue.
struct Node {
  UMockdevIoctlBase* handler = nullptr;
  Bytes descriptor;
  std::uint16_t vendor = 0, product = 0;
  int fd = -1;
  std::mutex mutex;
  std::deque<Bytes> queue;  // guarded by mutex, as the next two
  std::vector<Bytes> written;
  bool is_gone = false;
  bool holds_writes = false;  // guarded by mutex, as the next
  std::vector<UMockdevIoctlClient*> held;
  std::function<void(const Bytes&)> heard;  // guarded by mutex

  // The caller holds the mutex.
  void letWritesGo();
  void wake() const {
    const char token = 1;
    check(::write(fd, &token, 1) == 1, "waking a reader");
  }
};

namespace {

void put(UMockdevIoctlData* data, const void* bytes, std::size_t size) {
  Bytes copy(static_cast<const guint8*>(bytes), static_cast<const guint8*>(bytes) + size);
  umockdev_ioctl_data_update(data, 0, copy.data(), static_cast<gint>(size));
}

gboolean onIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer user) {
  Node& node = *static_cast<Node*>(user);
  const gulong request = umockdev_ioctl_client_get_request(client);
  if (_IOC_TYPE(request) != 'H') return FALSE;
  UMockdevIoctlData* const pointer = umockdev_ioctl_client_get_arg(client);
  UMockdevIoctlData* const data = umockdev_ioctl_data_resolve(pointer, 0, _IOC_SIZE(request), nullptr);
  check(data != nullptr, "an ioctl's argument");

  const int size = static_cast<int>(node.descriptor.size());
  hidraw_report_descriptor descriptor{};
  hidraw_devinfo info{};
  switch (_IOC_NR(request)) {
    case 1:
      put(data, &size, sizeof size);
      break;
    case 2:
      descriptor.size = static_cast<__u32>(size);
      std::copy(node.descriptor.begin(), node.descriptor.end(), descriptor.value);
      put(data, &descriptor, sizeof descriptor);
      break;
    case 3:
      info.bustype = 3;
      info.vendor = static_cast<__s16>(node.vendor);
      info.product = static_cast<__s16>(node.product);
      put(data, &info, sizeof info);
      break;
    default:
      umockdev_ioctl_data_unref(data);
      umockdev_ioctl_client_complete(client, -1, EINVAL);
      return TRUE;
  }
  umockdev_ioctl_data_unref(data);
  umockdev_ioctl_client_complete(client, 0, 0);
  return TRUE;
}

gboolean onRead(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer user) {
  Node& node = *static_cast<Node*>(user);
  gint error = 0;

  // Takes all waiting bytes; there is never more than one. The lock prevents that it also takes the byte of a new
  // report.
  const std::lock_guard lock(node.mutex);
  umockdev_ioctl_client_execute(client, &error, nullptr);
  if (node.is_gone) {
    umockdev_ioctl_client_complete(client, -1, EIO);
    return TRUE;
  }
  if (node.queue.empty()) {
    umockdev_ioctl_client_complete(client, -1, EAGAIN);
    return TRUE;
  }
  const Bytes report = std::move(node.queue.front());
  node.queue.pop_front();
  if (!node.queue.empty()) node.wake();
  put(umockdev_ioctl_client_get_arg(client), report.data(), report.size());
  umockdev_ioctl_client_complete(client, static_cast<glong>(report.size()), 0);
  return TRUE;
}

// The caller holds the node's mutex.
void takeWrite(Node& node, UMockdevIoctlClient* client) {
  const UMockdevIoctlData* const data = umockdev_ioctl_client_get_arg(client);
  const Bytes report(data->data, data->data + data->data_len);
  if (node.is_gone) {
    umockdev_ioctl_client_complete(client, -1, EIO);
    return;
  }
  node.written.push_back(report);
  if (node.heard) node.heard(report);
  umockdev_ioctl_client_complete(client, static_cast<glong>(data->data_len), 0);
}

}  // namespace

void Node::letWritesGo() {
  for (UMockdevIoctlClient* client : std::exchange(held, {})) {
    takeWrite(*this, client);
    g_object_unref(client);
  }
}

namespace {

gboolean onWrite(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer user) {
  Node& node = *static_cast<Node*>(user);
  const std::lock_guard lock(node.mutex);
  if (node.holds_writes)
    node.held.push_back(static_cast<UMockdevIoctlClient*>(g_object_ref(client)));
  else
    takeWrite(node, client);
  return TRUE;
}

std::string usbFolder(const SimulatedHid& what) {
  return fmt::format("/devices/pci0000:00/0000:00:14.0/usb1/1-{}", what.port);
}
std::string interfaceFolder(const SimulatedHid& what, std::size_t n) {
  return fmt::format("{}/1-{}:1.{}", usbFolder(what), what.port, n);
}
std::string hidName(const SimulatedHid& what, std::size_t n) {
  return fmt::format("0003:{:04X}:{:04X}.{:04X}", what.vendor, what.product, 16 * what.port + static_cast<int>(n));
}

}  // namespace

struct HidTestbed::State {
  UMockdevTestbed* bed = nullptr;
  std::map<int, std::unique_ptr<Node>> nodes;

  void add(const std::string& text) {
    GError* error = nullptr;
    if (umockdev_testbed_add_from_string(bed, text.c_str(), &error)) return;
    check(false, error ? error->message : text.c_str());
  }
};

bool HidTestbed::isThere() {
  const char* const preloaded = std::getenv("LD_PRELOAD");
  return preloaded && std::strstr(preloaded, "libumockdev-preload");
}

HidTestbed::HidTestbed() : state_(std::make_unique<State>()) { state_->bed = umockdev_testbed_new(); }

HidTestbed::~HidTestbed() {
  for (auto& [number, node] : state_->nodes) {
    umockdev_testbed_detach_ioctl(state_->bed, path(number).c_str(), nullptr);
    g_object_unref(node->handler);
  }
  g_object_unref(state_->bed);
}

void HidTestbed::plugIn(const SimulatedHid& what) {
  std::string serial = what.serial.empty() ? "" : "A: serial=" + what.serial + "\n";
  state_->add(
      fmt::format("P: {}\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\nA: idVendor={:04x}\nA: idProduct={:04x}\n"
                  "A: bcdDevice=0435\nA: manufacturer={}\nA: product={}\n{}",
                  usbFolder(what), what.vendor, what.product, what.maker, what.name, serial));

  for (std::size_t n = 0; n < what.interfaces.size(); ++n) {
    const int number = what.first_node + static_cast<int>(n);
    auto node = std::make_unique<Node>();
    node->descriptor = descriptorOf(what.interfaces[n].first, what.interfaces[n].second);
    node->vendor = what.vendor;
    node->product = what.product;

    const std::string interface = interfaceFolder(what, n), hid = interface + "/" + hidName(what, n);
    state_->add(
        fmt::format("P: {}\nE: DEVTYPE=usb_interface\nE: SUBSYSTEM=usb\nA: bInterfaceNumber={:02x}\n", interface, n));
    state_->add(fmt::format(
        "P: {}\nE: SUBSYSTEM=hid\nE: HID_ID=0003:{:08X}:{:08X}\nE: HID_NAME={} {}\n"
        "E: HID_PHYS=usb-0000:00:14.0-{}/input{}\nE: HID_UNIQ={}\nH: report_descriptor={}\n",
        hid, what.vendor, what.product, what.maker, what.name, what.port, n, what.serial, hex(node->descriptor)));
    state_->add(
        fmt::format("P: {0}/hidraw/hidraw{1}\nN: hidraw{1}\nE: DEVNAME=/dev/hidraw{1}\nE: MAJOR=240\nE: MINOR={1}\n"
                    "E: SUBSYSTEM=hidraw\nL: device=../../../{2}\n",
                    hid, number, hidName(what, n)));

    node->handler = umockdev_ioctl_base_new();
    g_signal_connect(node->handler, "handle-ioctl", G_CALLBACK(onIoctl), node.get());
    g_signal_connect(node->handler, "handle-read", G_CALLBACK(onRead), node.get());
    g_signal_connect(node->handler, "handle-write", G_CALLBACK(onWrite), node.get());
    check(umockdev_testbed_attach_ioctl(state_->bed, path(number).c_str(), node->handler, nullptr), "a handler");
    node->fd = umockdev_testbed_get_dev_fd(state_->bed, path(number).c_str());
    state_->nodes[number] = std::move(node);
  }
}

void HidTestbed::unplug(const SimulatedHid& what) {
  for (std::size_t n = what.interfaces.size(); n-- > 0;) {
    const int number = what.first_node + static_cast<int>(n);
    Node& node = *state_->nodes.at(number);
    {
      const std::lock_guard lock(node.mutex);
      node.is_gone = true;
      node.wake();
      node.letWritesGo();
    }
    const std::string hid = "/sys" + interfaceFolder(what, n) + "/" + hidName(what, n);
    umockdev_testbed_remove_device(state_->bed, (hid + "/hidraw/hidraw" + std::to_string(number)).c_str());
    umockdev_testbed_remove_device(state_->bed, hid.c_str());
    umockdev_testbed_remove_device(state_->bed, ("/sys" + interfaceFolder(what, n)).c_str());
  }
  umockdev_testbed_remove_device(state_->bed, ("/sys" + usbFolder(what)).c_str());
}

void HidTestbed::send(int node_number, const Bytes& report) {
  Node& node = *state_->nodes.at(node_number);
  const std::lock_guard lock(node.mutex);
  node.queue.push_back(report);
  if (node.queue.size() == 1) node.wake();
}

void HidTestbed::stream(int node_number, const Bytes& report) {
  constexpr std::size_t kMost = 64;
  Node& node = *state_->nodes.at(node_number);
  const std::lock_guard lock(node.mutex);
  if (node.queue.size() >= kMost) return;
  node.queue.push_back(report);
  if (node.queue.size() == 1) node.wake();
}

std::vector<Bytes> HidTestbed::written(int node_number) const {
  Node& node = *state_->nodes.at(node_number);
  const std::lock_guard lock(node.mutex);
  return node.written;
}

Bytes HidTestbed::lastWritten(int node_number) const {
  Node& node = *state_->nodes.at(node_number);
  const std::lock_guard lock(node.mutex);
  return node.written.empty() ? Bytes() : node.written.back();
}

void HidTestbed::holdWrites(int node_number, bool are_held) {
  Node& node = *state_->nodes.at(node_number);
  const std::lock_guard lock(node.mutex);
  node.holds_writes = are_held;
  if (!are_held) node.letWritesGo();
}

std::size_t HidTestbed::heldWrites(int node_number) const {
  Node& node = *state_->nodes.at(node_number);
  const std::lock_guard lock(node.mutex);
  return node.held.size();
}

void HidTestbed::forgetWritten(int node_number) {
  Node& node = *state_->nodes.at(node_number);
  const std::lock_guard lock(node.mutex);
  node.written.clear();
}

std::vector<Bytes> HidTestbed::takeWritten(int node_number) {
  Node& node = *state_->nodes.at(node_number);
  const std::lock_guard lock(node.mutex);
  return std::exchange(node.written, {});
}

void HidTestbed::listen(int node_number, std::function<void(const Bytes&)> heard) {
  Node& node = *state_->nodes.at(node_number);
  const std::lock_guard lock(node.mutex);
  node.heard = std::move(heard);
}

void HidTestbed::letOthersLook() {
  namespace fs = std::filesystem;
  gchar* const root = umockdev_testbed_get_root_dir(state_->bed);
  const fs::path folder(root);
  g_free(root);
  const auto look = fs::perms::others_read | fs::perms::others_exec;
  fs::permissions(folder, look, fs::perm_options::add);
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_directory() && !entry.is_symlink()) fs::permissions(entry.path(), look, fs::perm_options::add);
}

std::string HidTestbed::realPath(int node) const {
  gchar* const root = umockdev_testbed_get_root_dir(state_->bed);
  std::string out = root + path(node);
  g_free(root);
  return out;
}

}  // namespace kerf
