/* Reference bridge: docs/reference/device-bridge.md in C, with a simulated device in the place of a vendor's API.

   bridge PORT SECONDS: a mass in a hand that goes 2 mm down and stays. Prints what it felt, as one line of JSON. For a
   little-endian machine; where yours is not, swap the bytes. */
#define _POSIX_C_SOURCE 200809L
#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

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

_Static_assert(sizeof(HandFrame) == 152 && sizeof(ForceFrame) == 88, "the layout of the reference");

/* What a vendor's API would be: a place, and somewhere to put a force. One axis; m, N. */
typedef struct {
  double z, speed;
} Device;

static void step(Device* device, double wanted, double force, double dt) {
  const double mass = 0.1, hand_stiffness = 300, hand_damping = 6;
  const double push = force + hand_stiffness * (wanted - device->z) - hand_damping * device->speed;
  device->speed += dt * push / mass;
  device->z += dt * device->speed;
}

static double seconds_now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The newest force frame that waits; malformed and older ones are left out. */
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

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const int link = socket(AF_INET, SOCK_DGRAM, 0);
  struct sockaddr_in kerf;
  memset(&kerf, 0, sizeof kerf);
  kerf.sin_family = AF_INET;
  kerf.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  kerf.sin_port = htons((uint16_t)atoi(argv[1]));
  if (link < 0 || connect(link, (const struct sockaddr*)&kerf, sizeof kerf) != 0) return 1;

  Device device = {0, 0};
  ForceFrame force;
  memset(&force, 0, sizeof force);
  double heard = 0, most = 0;
  int enabled = 0, frames = 0, stops = 0;
  uint64_t number = 0;
  const double began = seconds_now(), lasts = atof(argv[2]);
  for (double now = began, last = began; now - began < lasts; now = seconds_now()) {
    if (newest_force(link, &force)) {
      enabled = force.enabled == 1;
      heard = now;
      ++frames;
    }
    if (enabled && now - heard > 1e-3 * force.deadline_ms) { /* the dead-man */
      enabled = 0;
      ++stops;
    }

    const double t = now - began - 0.5, applied = enabled ? force.force[2] : 0;
    if (applied > most) most = applied;
    step(&device, -0.002 * (t < 0 ? 0 : t > 1 ? 1 : t), applied, now - last < 0.005 ? now - last : 0.005);
    last = now;

    HandFrame hand;
    memset(&hand, 0, sizeof hand);
    memcpy(hand.magic, "KFD1", 4);
    hand.version = hand.kind = 1;
    hand.number = ++number;
    hand.time_ns = (uint64_t)(1e9 * now);
    hand.position[2] = device.z;
    hand.orientation[3] = 1;
    hand.velocity[2] = device.speed;
    hand.buttons = 1; /* the pedal */
    hand.flags = 1;   /* ready */
    hand.most_force = 4;
    hand.most_stiffness = 800;
    (void)send(link, &hand, sizeof hand, MSG_NOSIGNAL); /* refused: Kerf is not there yet, or no more */

    const struct timespec pause = {0, 1000000};
    nanosleep(&pause, NULL);
  }
  printf("{\"force_frames\": %d, \"most_force_N\": %.4f, \"stops\": %d, \"enabled\": %d, \"z_mm\": %.4f}\n", frames,
         most, stops, enabled, 1000 * device.z);
  close(link);
  return 0;
}
