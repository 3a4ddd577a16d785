"""Reads a recording with two independent implementations and prints what it holds as JSON.

Channels of ROS 2 are decoded by both; odometry is compared with the bytes of the layer for replay.
"""

import json
import struct
import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

file = Path(sys.argv[1])
result = {"metadata": {}, "counts": {}, "rosbags": {}}

with file.open("rb") as stream:
    reader = make_reader(stream, decoder_factories=[DecoderFactory()])
    summary = reader.get_summary()
    channels = summary.channels.values()
    layouts = {it.topic: it.metadata for it in channels}
    result["profile"] = reader.get_header().profile
    for metadata in reader.iter_metadata():
        result["metadata"][metadata.name] = metadata.metadata
    for _, channel, _ in reader.iter_messages():
        counts = result["counts"]
        counts[channel.topic] = counts.get(channel.topic, 0) + 1
    world = [it.topic for it in channels if it.message_encoding == "cdr"]
    decoded = {}
    odometry = []
    texts = {"/rosout": [], "/why": []}
    for _, channel, message, ros in reader.iter_decoded_messages(topics=world):
        decoded[channel.topic] = decoded.get(channel.topic, 0) + 1
        if channel.topic in texts:
            text = {"name": ros.name, "msg": ros.msg, "level": ros.level}
            texts[channel.topic].append(text)
        if channel.topic == "/odom":
            position = ros.pose.pose.position
            odometry.append([message.log_time, message.sequence, position.x, position.y])
    result["decoded"] = decoded
    result["rosout"], result["why"] = texts["/rosout"], texts["/why"]

    # The same numbers in the bytes, by the layout that the channel carries.
    name = "zeronav/" + sys.argv[2]
    layout = json.loads(layouts[name]["layout"])["envelope"]
    meta = next(it for it in layout["fields"] if it["name"] == "meta")
    pose = next(it for it in meta["type"]["fields"] if it["name"] == "pose")
    at = {it["name"]: meta["offset"] + pose["offset"] + it["offset"] for it in pose["type"]["fields"]}
    native = [
        [
            message.log_time,
            message.sequence,
            struct.unpack_from("<d", message.data, at["x_m"])[0],
            struct.unpack_from("<d", message.data, at["y_m"])[0],
        ]
        for _, _, message in reader.iter_messages(topics=[name])
    ]
    result["odometry"] = len(odometry)
    result["odometry_is_equal"] = odometry == native
    result["moved_m"] = max(it[2] for it in odometry) - min(it[2] for it in odometry)

with AnyReader([file]) as reader:
    wanted = [it for it in reader.connections if it.topic in world]
    for connection, _, raw in reader.messages(connections=wanted):
        reader.deserialize(raw, connection.msgtype)
        counts = result["rosbags"]
        counts[connection.topic] = counts.get(connection.topic, 0) + 1

# The run's own folder is a bag of rosbag2: topics, types and QoS come from its metadata.yaml.
if (file.parent / "metadata.yaml").exists():
    with Reader(file.parent) as reader:
        result["folder"] = {it.topic: it.msgcount for it in reader.connections if it.topic in world}
        result["folder_messages"] = reader.message_count
        result["folder_duration_ns"] = reader.duration
        result["folder_qos"] = {
            it.topic: [profile.durability.name.lower() for profile in it.ext.offered_qos_profiles]
            for it in reader.connections
            if it.topic in world
        }

print(json.dumps(result))
