/* A bridge for Force Dimension's devices (omega, delta, sigma, lambda, Falcon) and Kerf.

   NEVER COMPILED, NEVER TRIED: written by the public documentation of the DHD API, without the SDK or a device. It
   shows where its calls go. Begin with `kerf live --no-force`, a hand on the device's switch.

     cc -O2 force_dimension.c -I$SDK/include -L$SDK/lib -ldhd -lusb-1.0 -lpthread -o force_dimension_bridge
     ./force_dimension_bridge 4417

   Frames and the loop are those of tests/bridge/bridge.c, which runs in Kerf's tests; what differs is marked DHD. The
   device's own brakes and its limit of velocity stay on. */
#define _POSIX_C_SOURCE 200809L
#include <arpa/inet.h>
#include <dhdc.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

typedef struct {
  char magic[4];
  uint16_t version, kind;
  uint64_t number, time_ns;
  double position[3], orientation[4], velocity[3], angular[3];
  uint32_t buttons, flags;
  float most_force, most_torque, most_stiffness, reserved;
} HandFrame;

typedef struct {
  char magic[4];
  uint16_t version, kind;
  uint64_t number, hand_number, hand_time_ns;
  double force[3], torque[3];
  uint32_t enabled, deadline_ms;
} ForceFrame;

static double seconds_now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int newest_force(int link, ForceFrame* newest) {
  int found = 0;
  unsigned char bytes[256];
  for (;;) {
    const ssize_t size = recv(link, bytes, sizeof bytes, MSG_DONTWAIT);
    ForceFrame frame;
    if (size < 0) return found;
    if (size != (ssize_t)sizeof frame) continue;
    memcpy(&frame, bytes, sizeof frame);
    if (memcmp(frame.magic, "KFD1", 4) != 0 || frame.version != 1 || frame.kind != 2) continue;
    /* By the hand that it answers: a Kerf that was started again counts from 1. */
    if (frame.hand_time_ns < newest->hand_time_ns) continue;
    if (frame.hand_time_ns == newest->hand_time_ns && frame.number <= newest->number) continue;
    *newest = frame;
    found = 1;
  }
}

/* A rotation matrix as x y z w; good as long as the hand turns less than 120 degrees from upright. */
static void quaternion(double m[3][3], double q[4]) {
  q[3] = 0.5 * __builtin_sqrt(1 + m[0][0] + m[1][1] + m[2][2]);
  q[0] = (m[2][1] - m[1][2]) / (4 * q[3]);
  q[1] = (m[0][2] - m[2][0]) / (4 * q[3]);
  q[2] = (m[1][0] - m[0][1]) / (4 * q[3]);
}

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const int link = socket(AF_INET, SOCK_DGRAM, 0);
  struct sockaddr_in kerf;
  memset(&kerf, 0, sizeof kerf);
  kerf.sin_family = AF_INET;
  kerf.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  kerf.sin_port = htons((uint16_t)atoi(argv[1]));
  if (link < 0 || connect(link, (const struct sockaddr*)&kerf, sizeof kerf) != 0) return 1;
  if (dhdOpen() < 0) return fprintf(stderr, "%s\n", dhdErrorGetLastStr()), 1; /* DHD */

  ForceFrame force;
  memset(&force, 0, sizeof force);
  double heard = 0;
  int enabled = 0;
  uint64_t number = 0;
  for (;;) { /* DHD: dhdSetForce waits for the device's own 1 to 4 kHz */
    const double now = seconds_now();
    if (newest_force(link, &force)) {
      enabled = force.enabled == 1;
      heard = now;
    }
    if (enabled && now - heard > 0.001 * force.deadline_ms) enabled = 0; /* the dead-man */

    HandFrame hand;
    memset(&hand, 0, sizeof hand);
    memcpy(hand.magic, "KFD1", 4);
    hand.version = hand.kind = 1;
    hand.number = ++number;
    hand.time_ns = (uint64_t)(1e9 * now);
    double rotation[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (dhdGetPosition(&hand.position[0], &hand.position[1], &hand.position[2]) < 0) break; /* DHD: m */
    const int turns = dhdHasWrist() && dhdGetOrientationFrame(rotation) >= 0;               /* DHD */
    quaternion(rotation, hand.orientation);
    dhdGetLinearVelocity(&hand.velocity[0], &hand.velocity[1], &hand.velocity[2]); /* DHD */
    hand.buttons = dhdGetButton(0) == 1 ? 1 : 0;                                   /* DHD */
    hand.flags = 1 | (turns ? 2 : 0);
    hand.most_force = 8;        /* N: put yours */
    hand.most_stiffness = 1000; /* N/m: put yours, low at first */
    (void)send(link, &hand, sizeof hand, MSG_DONTWAIT | MSG_NOSIGNAL);

    if (dhdSetForce(enabled ? force.force[0] : 0, enabled ? force.force[1] : 0, enabled ? force.force[2] : 0) < 0)
      break;
  }
  dhdSetForce(0, 0, 0);
  dhdClose();
  return 1;
}
