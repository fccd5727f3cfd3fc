#!/usr/bin/env python3
"""Reference bridge: docs/reference/device-bridge.md in Python, with a simulated device in the place of a vendor's API.

bridge.py PORT SECONDS: a mass in a hand that goes 2 mm down and stays. Prints what it felt, as one line of JSON.
"""
import json
import socket
import struct
import sys
import time

HAND = struct.Struct("<4sHHQQ3d4d3d3dII4f")
FORCE = struct.Struct("<4sHHQQQ3d3dII")
assert HAND.size == 152 and FORCE.size == 88


class Device:
    """What a vendor's API would be: a place, and somewhere to put a force. One axis; m, N."""

    MASS, HAND_STIFFNESS, HAND_DAMPING = 0.1, 300.0, 6.0

    def __init__(self):
        self.z, self.speed = 0.0, 0.0

    def step(self, wanted, force, dt):
        push = force + self.HAND_STIFFNESS * (wanted - self.z) - self.HAND_DAMPING * self.speed
        self.speed += dt * push / self.MASS
        self.z += dt * self.speed


def order_of(frame):
    """By the hand that it answers: a Kerf that was started again counts from 1."""
    return frame[5], frame[3]


def newest_force(link, before):
    """The newest force frame that waits, None if there is none; malformed and older ones are left out."""
    found = None
    while True:
        try:
            data = link.recv(256)
        except (BlockingIOError, ConnectionRefusedError):
            return found
        if len(data) != FORCE.size:
            continue
        frame = FORCE.unpack(data)
        if frame[:3] != (b"KFD1", 1, 2) or order_of(frame) <= before:
            continue
        before, found = order_of(frame), frame


def main():
    port, seconds = int(sys.argv[1]), float(sys.argv[2])
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.connect(("127.0.0.1", port))
    link.setblocking(False)

    device = Device()
    force, enabled, deadline, heard, newest = 0.0, False, 0.0, 0.0, (0, 0)
    frames, most, stops = 0, 0.0, 0
    began = due = time.monotonic()
    last = began
    while (now := time.monotonic()) - began < seconds:
        if frame := newest_force(link, newest):
            newest, force, enabled, deadline, heard = order_of(frame), frame[8], frame[12] == 1, frame[13] / 1000, now
            frames += 1
        if enabled and now - heard > deadline:  # the dead-man
            enabled = False
            stops += 1

        wanted = -0.002 * min(1.0, max(0.0, now - began - 0.5))
        applied = force if enabled else 0.0
        most = max(most, abs(applied))
        device.step(wanted, applied, min(now - last, 0.005))
        last = now
        link_frame = HAND.pack(b"KFD1", 1, 1, int(now * 1e6), int(now * 1e9), 0, 0, device.z, 0, 0, 0, 1,
                               0, 0, device.speed, 0, 0, 0, 1, 1, 4.0, 0.0, 800.0, 0.0)
        try:
            link.send(link_frame)
        except ConnectionRefusedError:
            pass  # Kerf is not there yet, or no more
        due += 0.001
        time.sleep(max(0.0, due - time.monotonic()))
    print(json.dumps({"force_frames": frames, "most_force_N": most, "stops": stops, "enabled": int(enabled),
                      "z_mm": 1000 * device.z}))


main()
