// Drops a file on a window, as a file manager does (XDND 5): xdnd_drop WINDOW-NAME FILE. For tests; needs no window
// manager. Exit code 0: the window accepted it.
#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>

namespace {

Display* display = nullptr;
Atom atom(const char* name) { return XInternAtom(display, name, False); }

// The first window below `from` with that name; 0: none.
Window find(Window from, const std::string& name) {
  char* title = nullptr;
  if (XFetchName(display, from, &title) && title) {
    const bool is_it = name == title;
    XFree(title);
    if (is_it) return from;
  }
  Window root, parent, *children = nullptr;
  unsigned count = 0;
  if (!XQueryTree(display, from, &root, &parent, &children, &count)) return 0;
  Window found = 0;
  for (unsigned n = 0; n < count && !found; ++n) found = find(children[n], name);
  if (children) XFree(children);
  return found;
}

void send(Window to, const char* what, Window source, long a, long b, long c, long d) {
  XEvent e{};
  e.xclient = {.type = ClientMessage, .display = display, .window = to, .message_type = atom(what), .format = 32};
  const long data[] = {static_cast<long>(source), a, b, c, d};
  std::copy(std::begin(data), std::end(data), e.xclient.data.l);
  XSendEvent(display, to, False, NoEventMask, &e);
  XFlush(display);
}

// Hands over the list of files on request.
void answer(const XSelectionRequestEvent& request, const std::string& list) {
  XChangeProperty(display, request.requestor, request.property, request.target, 8, PropModeReplace,
                  reinterpret_cast<const unsigned char*>(list.data()), static_cast<int>(list.size()));
  XEvent e{};
  e.xselection = {.type = SelectionNotify,
                  .display = display,
                  .requestor = request.requestor,
                  .selection = request.selection,
                  .target = request.target,
                  .property = request.property,
                  .time = request.time};
  XSendEvent(display, request.requestor, False, NoEventMask, &e);
  XFlush(display);
}

std::string uriOf(const std::string& file) {
  std::string out = "file://";
  for (const char c : file) {
    char code[4] = {};
    if (c == ' ') std::snprintf(code, sizeof(code), "%%%02X", static_cast<unsigned>(c));
    out += c == ' ' ? code : std::string(1, c);
  }
  return out + "\r\n";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  std::string uris;
  for (int n = 2; n < argc; ++n) uris += uriOf(argv[n]);
  display = XOpenDisplay(nullptr);
  if (!display) return 2;
  const Window root = DefaultRootWindow(display), to = find(root, argv[1]);
  if (!to) return 3;

  const Window source = XCreateSimpleWindow(display, root, 0, 0, 1, 1, 0, 0, 0);
  const Atom type = atom("text/uri-list");
  XSetSelectionOwner(display, atom("XdndSelection"), source, CurrentTime);
  send(to, "XdndEnter", source, 5L << 24, static_cast<long>(type), 0, 0);
  send(to, "XdndPosition", source, 0, 200L << 16 | 150, CurrentTime, static_cast<long>(atom("XdndActionCopy")));

  const auto began = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - began < std::chrono::seconds(20)) {
    if (!XPending(display)) {
      ::usleep(10'000);
      continue;
    }
    XEvent e;
    XNextEvent(display, &e);
    if (e.type == SelectionRequest) answer(e.xselectionrequest, uris);
    if (e.type != ClientMessage) continue;
    if (e.xclient.message_type == atom("XdndStatus")) send(to, "XdndDrop", source, 0, CurrentTime, 0, 0);
    if (e.xclient.message_type == atom("XdndFinished")) return 0;
  }
  return 4;
}
