/* A bridge for 3D Systems' Touch by OpenHaptics and Kerf.

   NEVER COMPILED, NEVER TRIED: written by the public documentation of the HD API, without the SDK or a device. It shows
   where its calls go. Begin with `kerf live --no-force`.

     cc -O2 openhaptics.c -I$OH/include -L$OH/lib -lHD -lHDU -lrt -lpthread -o openhaptics_bridge
     ./openhaptics_bridge 4417

   Frames are those of tests/bridge/bridge.c, which runs in Kerf's tests: put its two structs and its newest_force()
   where this file says so; what differs is marked HD. Its scheduler calls back at 1 kHz; nothing here waits. */
#define _POSIX_C_SOURCE 200809L
#include <HD/hd.h>
#include <arpa/inet.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "frames_of_bridge.h" /* HandFrame, ForceFrame, newest_force(): from tests/bridge/bridge.c */

static int link_to_kerf = -1;
static ForceFrame force;
static double heard;
static int enabled;
static uint64_t number;

static double seconds_now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* HD: once a millisecond, by its own thread. Its frame is x right, y up, z to the person, in mm. */
static HDCallbackCode HDCALLBACK tick(void* unused) {
  (void)unused;
  const double now = seconds_now();
  if (newest_force(link_to_kerf, &force)) {
    enabled = force.enabled == 1;
    heard = now;
  }
  if (enabled && now - heard > 0.001 * force.deadline_ms) enabled = 0; /* the dead-man */

  hdBeginFrame(hdGetCurrentDevice());
  HDdouble place[3], speed[3], transform[16];
  HDint buttons = 0;
  hdGetDoublev(HD_CURRENT_POSITION, place);
  hdGetDoublev(HD_CURRENT_VELOCITY, speed);
  hdGetDoublev(HD_CURRENT_TRANSFORM, transform); /* by columns */
  hdGetIntegerv(HD_CURRENT_BUTTONS, &buttons);

  HandFrame hand;
  memset(&hand, 0, sizeof hand);
  memcpy(hand.magic, "KFD1", 4);
  hand.version = hand.kind = 1;
  hand.number = ++number;
  hand.time_ns = (uint64_t)(1e9 * now);
  for (int n = 0; n < 3; ++n) { /* x right, y away, z up; m */
    const double sign = n == 1 ? -1 : 1;
    const int of = n == 0 ? 0 : n == 1 ? 2 : 1;
    hand.position[n] = 0.001 * sign * place[of];
    hand.velocity[n] = 0.001 * sign * speed[of];
  }
  hand.orientation[3] = 1; /* the transform's rotation, turned as the place is: left to you */
  hand.buttons = ((buttons & HD_DEVICE_BUTTON_1) ? 1u : 0u) | ((buttons & HD_DEVICE_BUTTON_2) ? 2u : 0u);
  hand.flags = 1;
  hand.most_force = 3;       /* N: HD_NOMINAL_MAX_FORCE tells */
  hand.most_stiffness = 500; /* N/m: HD_NOMINAL_MAX_STIFFNESS tells, low at first */
  (void)send(link_to_kerf, &hand, sizeof hand, MSG_DONTWAIT | MSG_NOSIGNAL);

  const HDdouble felt[3] = {enabled ? force.force[0] : 0, enabled ? force.force[2] : 0, enabled ? -force.force[1] : 0};
  hdSetDoublev(HD_CURRENT_FORCE, felt);
  hdEndFrame(hdGetCurrentDevice());
  return HD_CALLBACK_CONTINUE;
}

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  link_to_kerf = socket(AF_INET, SOCK_DGRAM, 0);
  struct sockaddr_in kerf;
  memset(&kerf, 0, sizeof kerf);
  kerf.sin_family = AF_INET;
  kerf.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  kerf.sin_port = htons((uint16_t)atoi(argv[1]));
  if (link_to_kerf < 0 || connect(link_to_kerf, (const struct sockaddr*)&kerf, sizeof kerf) != 0) return 1;

  if (hdInitDevice(HD_DEFAULT_DEVICE) == HD_INVALID_HANDLE) return 1; /* HD */
  hdEnable(HD_FORCE_OUTPUT);
  hdEnable(HD_FORCE_RAMPING);
  hdEnable(HD_MAX_FORCE_CLAMPING);
  const HDSchedulerHandle handle = hdScheduleAsynchronous(tick, 0, HD_DEFAULT_SCHEDULER_PRIORITY);
  hdStartScheduler();
  for (;;) sleep(1);
  hdStopScheduler();
  hdUnschedule(handle);
  return 0;
}
