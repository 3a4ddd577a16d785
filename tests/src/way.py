"""A way between two network namespaces that is as bad as asked: packets are late, lost, overtake each other, or wait for
a narrow line.

Usage: way.py NAMESPACE ADDRESS NAMESPACE ADDRESS

Makes both namespaces with a loopback and one device each (addresses such as 10.77.0.1/24), prints `ready`, and reads one
JSON object per line from standard input, which says how the way is from then on:

    {"loss": 0.02, "delay_s": 0.02, "jitter_s": 0.01, "bytes_per_s": 125000, "cut": false, "half": false}

What is not named is as on a perfect way. `cut` loses everything, `half` everything in one direction. Ends, and removes
the namespaces, when standard input ends. With `--plain` as a last argument the two devices are a pair of the kernel,
which costs no processor time and cannot be made bad.
"""

import ctypes
import fcntl
import heapq
import json
import os
import random
import select
import struct
import subprocess
import sys
import time

TUNSETIFF = 0x400454CA
IFF_TUN = 0x0001
IFF_NO_PI = 0x1000
CLONE_NEWNET = 0x40000000
PACKET_BYTES = 65536
# What a router keeps before it drops.
WAITING_BYTES = 64 * 1024

libc = ctypes.CDLL(None, use_errno=True)


def run(*words):
    subprocess.run(words, check=True, stdin=subprocess.DEVNULL)


def enter(path):
    with open(path) as namespace:
        if libc.setns(namespace.fileno(), CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), f"entering {path}")


def device(namespace, address):
    """Makes a namespace with a device; the device's other end."""
    run("ip", "netns", "add", namespace)
    enter(f"/run/netns/{namespace}")
    end = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(end, TUNSETIFF, struct.pack("16sH", b"way", IFF_TUN | IFF_NO_PI))
    run("ip", "link", "set", "lo", "up")
    run("ip", "address", "add", address, "dev", "way")
    run("ip", "link", "set", "way", "up", "mtu", "1400")
    return end


def pair(names, addresses):
    """Makes both namespaces with a pair of devices."""
    for name in names:
        run("ip", "netns", "add", name)
    devices = [f"zn{os.getpid() % 1000000}{side}" for side in "ab"]
    run("ip", "link", "add", devices[0], "type", "veth", "peer", "name", devices[1])
    for name, plain, address in zip(names, devices, addresses):
        run("ip", "link", "set", plain, "netns", name)
        inside = ("ip", "-n", name)
        run(*inside, "link", "set", "lo", "up")
        run(*inside, "address", "add", address, "dev", plain)
        run(*inside, "link", "set", plain, "up")


class Way:
    def __init__(self, ends):
        self.ends = ends
        self.random = random.Random(1)
        self.how = {}
        self.due = []
        self.count = 0
        self.free_at = [0.0, 0.0]
        self.waiting = [0, 0]

    def take(self, side):
        """Packets that have come on one side are put where they come out later, or nowhere."""
        while True:
            try:
                packet = os.read(self.ends[side], PACKET_BYTES)
            except BlockingIOError:
                return
            how = self.how
            lost = how.get("cut") or (how.get("half") and side == 0) or self.random.random() < how.get("loss", 0.0)
            if lost:
                continue
            at = time.monotonic()
            rate = how.get("bytes_per_s")
            if rate:
                if self.waiting[side] > WAITING_BYTES:
                    continue
                at = max(at, self.free_at[side]) + len(packet) / rate
                self.free_at[side] = at
            jitter_s = how.get("jitter_s", 0.0)
            at += max(0.0, how.get("delay_s", 0.0) + self.random.uniform(-jitter_s, jitter_s))
            self.count += 1
            self.waiting[side] += len(packet)
            heapq.heappush(self.due, (at, self.count, 1 - side, packet))

    def give(self):
        now = time.monotonic()
        while self.due and self.due[0][0] <= now:
            _, _, side, packet = heapq.heappop(self.due)
            self.waiting[1 - side] -= len(packet)
            try:
                os.write(self.ends[side], packet)
            except OSError:
                # Its queue is full, or the device is down: lost.
                pass

    def serve(self):
        said = b""
        while True:
            wait_s = max(0.0, self.due[0][0] - time.monotonic()) if self.due else None
            ready, _, _ = select.select([0, *self.ends], [], [], wait_s)
            if 0 in ready:
                piece = os.read(0, 65536)
                if not piece:
                    return
                said += piece
                *lines, said = said.split(b"\n")
                for line in lines:
                    self.how = json.loads(line)
                    print("done", flush=True)
            for side, end in enumerate(self.ends):
                if end in ready:
                    self.take(side)
            self.give()


def main():
    own = f"/proc/{os.getpid()}/ns/net"
    home = os.open(own, os.O_RDONLY)
    names, addresses = (sys.argv[1], sys.argv[3]), (sys.argv[2], sys.argv[4])
    try:
        ends = []
        if sys.argv[5:] == ["--plain"]:
            pair(names, addresses)
            print("ready", flush=True)
            sys.stdin.read()
            return
        for name, address in zip(names, addresses):
            ends.append(device(name, address))
            libc.setns(home, CLONE_NEWNET)
        print("ready", flush=True)
        Way(ends).serve()
    finally:
        libc.setns(home, CLONE_NEWNET)
        for name in names:
            subprocess.run(["ip", "netns", "delete", name], stderr=subprocess.DEVNULL)


main()
