#!/usr/bin/env python3
"""A client of Nav2 as scripts and tools are: it watches what is published and sends goals by actions and topics.

Orders come on standard input, a JSON object a line; what happens goes to standard output in the same form.
"""

import json
import math
import sys
import threading

import rclpy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import FollowWaypoints, NavigateThroughPoses, NavigateToPose
from nav_msgs.msg import OccupancyGrid, Path
from rclpy.action import ActionClient
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from tf2_msgs.msg import TFMessage

LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def pose(numbers, frame="map"):
    x, y, yaw = numbers
    message = PoseStamped()
    message.header.frame_id = frame
    message.pose.position.x = float(x)
    message.pose.position.y = float(y)
    message.pose.orientation.z = math.sin(yaw / 2.0)
    message.pose.orientation.w = math.cos(yaw / 2.0)
    return message


class Client(Node):
    def __init__(self):
        super().__init__("client")
        self.lock = threading.Lock()
        self.handles = {}
        self.frames = set()
        self.to_pose = ActionClient(self, NavigateToPose, "navigate_to_pose")
        self.through = ActionClient(self, NavigateThroughPoses, "navigate_through_poses")
        self.waypoints = ActionClient(self, FollowWaypoints, "follow_waypoints")
        self.goal_pose = self.create_publisher(PoseStamped, "goal_pose", 10)
        self.initial_pose = self.create_publisher(PoseWithCovarianceStamped, "initialpose", 10)
        self.create_subscription(OccupancyGrid, "map", self.see_map, LATCHED)
        self.create_subscription(OccupancyGrid, "local_costmap/costmap", self.see_costs, LATCHED)
        self.create_subscription(Path, "plan", self.see_plan, 10)
        self.create_subscription(PoseWithCovarianceStamped, "amcl_pose", self.see_pose, LATCHED)
        self.create_subscription(TFMessage, "tf", self.see_tf, 100)

    def say(self, **what):
        with self.lock:
            print(json.dumps(what), flush=True)

    def see_costs(self, message):
        info, cells = message.info, list(message.data)
        corner = [info.origin.position.x, info.origin.position.y]
        side = [info.width * info.resolution, info.height * info.resolution]
        between = sum(1 for cell in cells if 0 < cell < 99)
        counts = {"obstacle": cells.count(100), "inscribed": cells.count(99), "between": between}
        self.say(kind="costs", frame=message.header.frame_id, corner=corner, side=side, **counts)

    def see_map(self, message):
        info = message.info
        occupied = sum(1 for cell in message.data if cell == 100)
        self.say(kind="map", width=info.width, height=info.height, resolution=info.resolution, occupied=occupied)

    def see_plan(self, message):
        self.say(kind="plan", n=len(message.poses), frame=message.header.frame_id)

    def see_pose(self, message):
        at = message.pose.pose.position
        self.say(kind="pose", x=at.x, y=at.y)

    def see_tf(self, message):
        for it in message.transforms:
            names = (it.header.frame_id, it.child_frame_id)
            if names not in self.frames:
                self.frames.add(names)
                at = it.transform.translation
                self.say(kind="tf", parent=names[0], child=names[1], x=at.x, y=at.y)

    def order(self, it):
        what = it["order"]
        if what == "go":
            goal = NavigateToPose.Goal()
            goal.pose = pose(it["pose"], it.get("frame", "map"))
            self.send(self.to_pose, goal, it["name"])
        elif what == "through":
            goal = NavigateThroughPoses.Goal()
            poses = [pose(numbers) for numbers in it["poses"]]
            if hasattr(goal.poses, "goals"):
                goal.poses.goals = poses
            else:
                goal.poses = poses
            self.send(self.through, goal, it["name"])
        elif what == "waypoints":
            goal = FollowWaypoints.Goal()
            goal.poses = [pose(numbers) for numbers in it["poses"]]
            self.send(self.waypoints, goal, it["name"])
        elif what == "cancel":
            self.handles[it["name"]].cancel_goal_async().add_done_callback(
                lambda done: self.say(kind="cancelling", name=it["name"], n=len(done.result().goals_canceling))
            )
        elif what == "goal_pose":
            for _ in range(it.get("times", 1)):
                self.goal_pose.publish(pose(it["pose"], it.get("frame", "map")))
        elif what == "initialpose":
            message = PoseWithCovarianceStamped()
            stamped = pose(it["pose"])
            message.header = stamped.header
            message.pose.pose = stamped.pose
            self.initial_pose.publish(message)
        elif what == "state":
            client = self.create_client(GetState, it["node"] + "/get_state")
            if not client.wait_for_service(timeout_sec=10.0):
                self.say(kind="state", node=it["node"], label="no service")
                return
            client.call_async(GetState.Request()).add_done_callback(
                lambda done: self.say(kind="state", node=it["node"], label=done.result().current_state.label)
            )

    def send(self, client, goal, name):
        if not client.wait_for_server(timeout_sec=20.0):
            self.say(kind="accepted", name=name, accepted=False, why="no server")
            return
        future = client.send_goal_async(goal, lambda it: self.feedback(name, it.feedback))
        future.add_done_callback(lambda done: self.accepted(name, done.result()))

    def feedback(self, name, it):
        if hasattr(it, "current_waypoint"):
            self.say(kind="feedback", name=name, waypoint=it.current_waypoint)
            return
        at = it.current_pose.pose.position
        self.say(
            kind="feedback",
            name=name,
            x=at.x,
            y=at.y,
            left=it.distance_remaining,
            elapsed=it.navigation_time.sec,
            recoveries=it.number_of_recoveries,
            poses=getattr(it, "number_of_poses_remaining", None),
        )

    def accepted(self, name, handle):
        self.handles[name] = handle
        self.say(kind="accepted", name=name, accepted=handle.accepted)
        if handle.accepted:
            handle.get_result_async().add_done_callback(lambda done: self.ended(name, done.result()))

    def ended(self, name, it):
        code = getattr(it.result, "error_code", None)
        why = getattr(it.result, "error_msg", None)
        missed = getattr(it.result, "missed_waypoints", None)
        missed = None if missed is None else len(missed)
        self.say(kind="result", name=name, status=it.status, code=code, why=why, missed=missed)


def spin(executor):
    try:
        executor.spin()
    except ExternalShutdownException:
        pass


def main():
    rclpy.init()
    client = Client()
    executor = MultiThreadedExecutor()
    executor.add_node(client)
    spinning = threading.Thread(target=spin, args=(executor,), daemon=True)
    spinning.start()
    client.say(kind="ready")
    try:
        for line in sys.stdin:
            client.order(json.loads(line))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        executor.shutdown(timeout_sec=1.0)
        spinning.join(timeout=1.0)
        # Fast DDS removes its shared memory with the last node, not with the interpreter.
        client.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
