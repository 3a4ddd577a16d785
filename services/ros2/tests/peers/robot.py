#!/usr/bin/env python3
"""A robot of ROS 2, as somebody's driver would be: rclpy, its own clock and frames, and no word of this project.

Its hardware is a program that speaks a line protocol over a pipe. It writes what happens to it to standard output, a
JSON object a line.
"""

import argparse
import json
import math
import queue
import random
import subprocess
import sys
import threading
import time

import rclpy
from geometry_msgs.msg import TransformStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage


def stamp(message, ns):
    message.header.stamp.sec = ns // 1_000_000_000
    message.header.stamp.nanosec = ns % 1_000_000_000


class Robot(Node):
    def __init__(self, args):
        super().__init__(args.name)
        self.args = args
        self.lock = threading.Lock()
        self.origin = None
        self.commanded_ns = None
        self.random = random.Random(7)
        self.late = queue.Queue()
        self.moving = False
        reliable = QoSProfile(depth=10)
        self.odom = self.create_publisher(Odometry, args.odom, reliable)
        self.scan = self.create_publisher(LaserScan, args.scan, qos_profile_sensor_data)
        if args.stamped:
            self.create_subscription(TwistStamped, args.cmd_vel, self.drive_stamped, reliable)
        else:
            self.create_subscription(Twist, args.cmd_vel, self.hear, reliable)
        self.tf = self.create_publisher(TFMessage, args.tf, reliable)
        if args.laser:
            latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            self.tf_static = self.create_publisher(TFMessage, args.tf_static, latched)
            self.tf_static.publish(self.transform(0, args.base_frame, args.laser_frame, *args.laser))
        self.hardware = subprocess.Popen(
            [args.hardware, args.config, str(args.tick_hz)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.zero_ns = time.time_ns()
        for work in (self.measure, self.deliver):
            threading.Thread(target=self.until_the_end, args=(work,), daemon=True).start()

    def until_the_end(self, work):
        try:
            work()
        except Exception:
            # Nothing can be published once the node is gone.
            if rclpy.ok():
                raise

    def say(self, **what):
        with self.lock:
            print(json.dumps(what), flush=True)

    def over_network(self, act, *arguments):
        """A network that loses some and delays all of what goes through it."""
        if self.random.random() < self.args.lose:
            return
        if self.args.delay_ms > 0.0:
            self.late.put((time.monotonic() + self.args.delay_ms / 1e3, act, arguments))
        else:
            act(*arguments)

    def deliver(self):
        while True:
            due, act, arguments = self.late.get()
            time.sleep(max(0.0, due - time.monotonic()))
            act(*arguments)

    def hear(self, twist):
        self.over_network(self.drive, twist)

    def drive(self, twist):
        v, w = twist.linear.x, twist.angular.z
        self.commanded_ns = time.time_ns()
        is_moving = v != 0.0 or w != 0.0
        if is_moving != self.moving:
            self.moving = is_moving
            self.say(kind="command", v=v, w=w, t_ns=self.commanded_ns)
        try:
            self.hardware.stdin.write(f"{v} {w}\n")
            self.hardware.stdin.flush()
        except (BrokenPipeError, ValueError):
            pass

    def drive_stamped(self, message):
        if self.args.delays:
            sent_ns = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
            self.say(kind="delay", us=(time.time_ns() - sent_ns) / 1e3)
        self.hear(message.twist)

    def measure(self):
        for line in self.hardware.stdout:
            kind, ns, *numbers = line.split(" ")
            numbers = [float(number) for number in numbers]
            at_ns = self.zero_ns + int(ns) + int(self.args.clock_ahead_s * 1e9)
            if kind == "O":
                self.publish_odometry(at_ns, *numbers)
            elif kind == "S":
                self.publish_scan(at_ns, *numbers[:5], numbers[5:])
            elif kind == "T":
                x, y, yaw, v, moving, standing = numbers
                self.say(kind="truth", x=x, y=y, yaw=yaw, v=v, contacts=moving + standing)

    def transform(self, at_ns, parent, child, x, y, yaw):
        it = TransformStamped()
        stamp(it, at_ns)
        it.header.frame_id = parent
        it.child_frame_id = child
        it.transform.translation.x = x
        it.transform.translation.y = y
        it.transform.rotation.z = math.sin(yaw / 2.0)
        it.transform.rotation.w = math.cos(yaw / 2.0)
        return TFMessage(transforms=[it])

    def publish_odometry(self, at_ns, x, y, yaw, v, w):
        if self.origin is None:
            # Odometry of a robot that was switched on here.
            self.origin = (x, y, yaw)
        x0, y0, yaw0 = self.origin
        dx, dy = x - x0, y - y0
        x = math.cos(yaw0) * dx + math.sin(yaw0) * dy
        y = -math.sin(yaw0) * dx + math.cos(yaw0) * dy
        turn = yaw - yaw0
        message = Odometry()
        stamp(message, at_ns)
        message.header.frame_id = self.args.odom_frame
        message.child_frame_id = self.args.base_frame
        message.pose.pose.position.x = x
        message.pose.pose.position.y = y
        message.pose.pose.orientation.z = math.sin(turn / 2.0)
        message.pose.pose.orientation.w = math.cos(turn / 2.0)
        message.twist.twist.linear.x = v
        message.twist.twist.angular.z = w
        self.over_network(self.odom.publish, message)
        transform = self.transform(at_ns, self.args.odom_frame, self.args.base_frame, x, y, turn)
        self.over_network(self.tf.publish, transform)

    def publish_scan(self, at_ns, angle_min, angle_increment, time_increment, range_min, range_max, ranges):
        message = LaserScan()
        # The stamp is that of the first beam.
        stamp(message, at_ns - int(time_increment * (len(ranges) - 1) * 1e9))
        message.header.frame_id = self.args.laser_frame
        message.angle_min = angle_min
        message.angle_max = angle_min + angle_increment * (len(ranges) - 1)
        message.angle_increment = angle_increment
        message.time_increment = time_increment
        message.range_min = range_min
        message.range_max = range_max
        message.ranges = ranges
        self.over_network(self.scan.publish, message)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("hardware")
    parser.add_argument("config")
    parser.add_argument("--name", default="robot")
    parser.add_argument("--tick-hz", type=float, default=50.0)
    parser.add_argument("--scan", default="/scan")
    parser.add_argument("--odom", default="/odom")
    parser.add_argument("--cmd-vel", default="/cmd_vel")
    parser.add_argument("--tf", default="/tf")
    parser.add_argument("--tf-static", default="/tf_static")
    parser.add_argument("--stamped", action="store_true")
    parser.add_argument("--delays", action="store_true", help="say how long stamped commands were on their way")
    parser.add_argument("--lose", type=float, default=0.0, help="share of messages that is lost, either way")
    parser.add_argument("--delay-ms", type=float, default=0.0, help="by which each message comes later, either way")
    parser.add_argument("--odom-frame", default="odom")
    parser.add_argument("--base-frame", default="base_link")
    parser.add_argument("--laser-frame", default="laser")
    parser.add_argument("--laser", type=float, nargs=3, metavar=("X", "Y", "YAW"), help="its mount, for /tf_static")
    parser.add_argument("--clock-ahead-s", type=float, default=0.0)
    args = parser.parse_args()
    rclpy.init()
    robot = Robot(args)
    executor = SingleThreadedExecutor()
    executor.add_node(robot)
    try:
        executor.spin()
    except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        pass
    finally:
        robot.hardware.kill()
        # Fast DDS removes its shared memory with the last node, not with the interpreter.
        robot.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    sys.exit(main())
