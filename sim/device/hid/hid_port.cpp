#include "sim/device/hid/hid_port.h"

#include <fmt/format.h>
#include <hidapi/hidapi.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <system_error>

namespace kerf {
namespace {

namespace fs = std::filesystem;

// Converts a device's text to UTF-8 without control characters, for any input.
std::string utf8(const wchar_t* text) {
  std::string out;
  for (; text && *text; ++text) {
    const auto c = static_cast<std::uint32_t>(*text);
    if (c < 0x20 || c == 0x7F) continue;
    if (c < 0x80) {
      out += static_cast<char>(c);
    } else if (c < 0x800) {
      out += static_cast<char>(0xC0 | (c >> 6));
      out += static_cast<char>(0x80 | (c & 0x3F));
    } else if (c < 0x10000 && (c < 0xD800 || c > 0xDFFF)) {
      out += static_cast<char>(0xE0 | (c >> 12));
      out += static_cast<char>(0x80 | ((c >> 6) & 0x3F));
      out += static_cast<char>(0x80 | (c & 0x3F));
    } else {
      out += '?';
    }
  }
  return out;
}

// On USB /sys/class/hidraw/hidraw0/device is .../USB-DEVICE/INTERFACE/HID-DEVICE. Elsewhere it is the HID device
// itself.
std::string parentOf(const std::string& path, bool is_usb) {
  std::error_code error;
  const fs::path link = fs::path("/sys/class/hidraw") / fs::path(path).filename() / "device";
  const fs::path hid = fs::canonical(link, error);
  if (error) return path;
  return is_usb ? hid.parent_path().parent_path().string() : hid.string();
}

// Initialises once, at the first call; the library's own exit is left to the end of the process.
void initOnce() {
  static const int done = hid_init();
  (void)done;
}

// hidapi keeps the text of the last error of listing and opening for the whole process: two concurrent searches would
// free it twice.
std::mutex finding;

}  // namespace

std::vector<HidInfo> listHid() {
  const std::lock_guard one(finding);
  initOnce();
  std::vector<HidInfo> out;
  hid_device_info* const first = hid_enumerate(0, 0);
  for (const hid_device_info* at = first; at; at = at->next) {
    HidInfo info;
    info.path = at->path ? at->path : "";
    info.vendor = at->vendor_id;
    info.product = at->product_id;
    info.usage_page = at->usage_page;
    info.usage = at->usage;
    info.interface = at->interface_number;
    info.serial = utf8(at->serial_number);
    info.parent = parentOf(info.path, at->bus_type == HID_API_BUS_USB);
    info.may_open = ::access(info.path.c_str(), R_OK | W_OK) == 0;
    out.push_back(std::move(info));
  }
  hid_free_enumeration(first);

  // A device with several collections is listed once for each.
  std::stable_sort(out.begin(), out.end(), [](const HidInfo& a, const HidInfo& b) { return a.path < b.path; });
  const auto is_same = [](const HidInfo& a, const HidInfo& b) { return a.path == b.path; };
  out.erase(std::unique(out.begin(), out.end(), is_same), out.end());
  return out;
}

// hidapi keeps the text of a device's last error in the device: two calls that fail at once would free it twice. Hence
// one handle for each way. The system keeps 64 reports for the handle without a reader, and drops later ones.
struct HidPort::Handle {
  hid_device* reads = nullptr;
  hid_device* writes = nullptr;
  std::mutex writing;
  ~Handle() {
    for (hid_device* device : {reads, writes})
      if (device) hid_close(device);
  }
};

HidPort::HidPort(std::unique_ptr<Handle> handle) : handle_(std::move(handle)) {}
HidPort::HidPort(HidPort&&) noexcept = default;
HidPort& HidPort::operator=(HidPort&&) noexcept = default;
HidPort::~HidPort() = default;

Expected<HidPort> HidPort::open(const std::string& path) {
  {
    const std::lock_guard one(finding);
    initOnce();
  }
  // Checked first: the library's error on opening varies.
  const bool is_there = ::access(path.c_str(), F_OK) == 0;
  if (is_there && ::access(path.c_str(), R_OK | W_OK) != 0)
    return fail({.code = Error::Code::kUnreadable,
                 .file = path,
                 .found = "no permission to open the device",
                 .expected = "permission to read and write it",
                 .hint = "run scripts/setup --udev, which installs the udev rule 70-kerf-hid.rules; then unplug the "
                         "device and plug it in again"});

  auto handle = std::make_unique<Handle>();
  const std::lock_guard one(finding);
  errno = 0;
  handle->reads = hid_open_path(path.c_str());
  if (handle->reads) handle->writes = hid_open_path(path.c_str());
  if (handle->writes) return HidPort(std::move(handle));
  const int reason = errno;
  return fail({.code = Error::Code::kNotFound,
               .file = path,
               .found = fmt::format("no device that opens ({})", reason ? std::strerror(reason) : "no reason given"),
               .expected = "a HID device",
               .hint = "list the connected devices with kerf devices"});
}

int HidPort::read(std::span<std::uint8_t> report, int wait_ms) noexcept {
  return hid_read_timeout(handle_->reads, report.data(), report.size(), wait_ms);
}

bool HidPort::write(std::span<const std::uint8_t> report) noexcept {
  const std::lock_guard lock(handle_->writing);
  return hid_write(handle_->writes, report.data(), report.size()) >= 0;
}

}  // namespace kerf
