#!/usr/bin/env python3
"""trace.mcap against the recording that it was made of, by three readers that share no code with it or each other.

    pip install mcap-ros2-support rosbags 'rerun-sdk[catalog]'
    python tools/check_trace.py DIR

DIR is the folder of a run. mcap-ros2-support and rosbags decode every message by the definitions in the file, and every value must
be what record.jsonl says (float32 fields to their precision). Rerun converts the file with its own ROS 2 decoders, and its
transforms, joints and points must be the same. Exit status 1 at the first difference; 3 where a reader is not installed.
"""
import argparse
import json
import math
import subprocess
import sys
import sysconfig
import tempfile
from collections import defaultdict
from pathlib import Path

try:
    import numpy as np
    import rerun
    import rosbags.rosbag2
    import rosbags.typesys
    from mcap_ros2.reader import read_ros2_messages
except ImportError as missing:
    print(f"not checked: {missing}")
    sys.exit(3)


def planar(base):
    x, y, yaw = base
    return [x, y, 0.0, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)]


def expected(folder):
    """For each topic the messages that the recording asks for, as (time, value)."""
    topics = defaultdict(list)
    grid = begin = activity = None
    states = None
    kinds = {}
    for line in (folder / "record.jsonl").read_text().splitlines():
        time, event = json.loads(line)
        (kind, e), = event.items()
        say = lambda topic, value: topics[topic].append((round(time * 1e9), value))
        if kind == "begin":
            begin, grid = e, e["grid"]
            nx, ny, nz = grid["size"]
            low, size = np.array(grid["low"]), grid["cell_size"]
            states = np.zeros(nx * ny * nz, np.uint8)
            if e["ground"]["tags"]:
                say("/tags", [("tags", t["id"], 0, t["center"], []) for t in e["ground"]["tags"]])
            if e["volumes"]:
                boxes = enumerate(e["volumes"])
                say("/volumes", [("volumes", i, 0, [(a + b) / 2 for a, b in zip(v["low"], v["high"])], []) for i, v in boxes])
            centers = lambda index: low + (np.stack([index % nx, index // nx % ny, index // (nx * ny)], -1) + 0.5) * size
        elif kind == "pose":
            say("/tf", [("base_link", planar(e["base"])), ("camera_optical_frame", e["camera"]["p"] + e["camera"]["q"])])
            say("/joint_states", (begin["robot"]["joints"], e["joints"]))
        elif kind == "cells":
            index = np.concatenate([np.arange(first, first + length) for first, length, _ in e] or [np.array([], int)])
            value = np.concatenate([np.full(length, v) for _, length, v in e] or [np.array([], int)])
            states[index] = value
            if begin["system"] == "flap" and time == 0:
                index, value = index[value != 1], value[value != 1]
            say("/voxels", (centers(index), value))
        elif kind == "scan":
            points = np.array(e["origin"]) + 0.01 * np.array(e["points"]).reshape(-1, 3)
            say("/depth" if e["sensor"] == "depth" else "/lidar", (points, None))
        elif kind == "plan":
            due = [e["ready"] + e["step"] * k for k in range(len(e["base"]))]
            say("/plan", [(t, planar(p)) for t, p in zip(due, e["base"])])
            say("/camera_plan", [(t, p + [0, 0, 0, 1]) for t, p in zip(due, e["camera"])])
        elif kind == "horizon":
            say("/horizon", [(time, planar(p)) for p in e["base"]])
        elif kind == "frontiers":
            names = "exploration", "inspection"
            gone = [(name, i, 2, [0, 0, 0], []) for i in e["gone"] for name in names]
            new = [(names[c["inspection"]], c["id"], 0, [0, 0, 0], centers(np.cumsum(c["steps"]))) for c in e["clusters"]]
            say("/frontiers", gone + new)
        elif kind == "decision":
            views = [c["view"] for c in e["candidates"]]
            chosen = [] if e["chosen"] is None else [views[e["chosen"]]]
            say("/viewpoints", [("candidates", 0, 0 if views else 2, [0, 0, 0], sight(views)), ("chosen", 0, 0 if chosen else 2, [0, 0, 0], sight(chosen))])
        elif kind == "found":
            say("/tags", [("tags", e["id"], 0, e["center"], [])])
        elif kind == "progress":
            say("/explored", e["explored"]), say("/inspected", e["inspected"]), say("/tags_found", e["found"])
            if e["activity"] != activity:
                activity = e["activity"]
                say("/activity", activity)
        elif kind == "look":
            say("/tf", [("base_link", planar(e["base"] + [0])), ("camera_optical_frame", e["camera"]["p"] + e["camera"]["q"])])
            say("/success", e["probability"])
    # The map from above at the end: any occupied voxel makes a column occupied, any free one alone makes it free.
    first, last = begin["layers"]
    columns = states.reshape(nz, ny, nx)[first:last]
    ground = np.where((columns > 1).any(0), 100, np.where((columns == 1).any(0), 0, -1)).ravel()
    return topics, (ground, nx, ny, size, low)


def sight(views):
    """Two points for each view: the camera, and 0.3 m along its axis."""
    out = []
    for view in views:
        x, y, z, w = view["q"]
        axis = [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)]
        out += [view["p"], [p + 0.3 * a for p, a in zip(view["p"], axis)]]
    return out


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def pose_of(pose):
    p, q = (pose.translation, pose.rotation) if hasattr(pose, "translation") else (pose.position, pose.orientation)
    return [p.x, p.y, p.z, q.x, q.y, q.z, q.w]


def close(what, a, b, tolerance=1e-9):
    a, b = np.asarray(a, float), np.asarray(b, float)
    if a.shape != b.shape or (a.size and np.abs(a - b).max() > tolerance):
        sys.exit(f"{what}: {a.tolist()} is not {b.tolist()}")


def same(what, a, b):
    if a != b:
        sys.exit(f"{what}: {a!r} is not {b!r}")


def cloud_of(message):
    fields = {f.name: (f.offset, f.datatype) for f in message.fields}
    raw = np.frombuffer(bytes(message.data), np.uint8).reshape(-1, message.point_step)
    same("points", len(raw), message.width)
    axis = lambda name: raw[:, fields[name][0]:fields[name][0] + 4].copy().view("<f4")[:, 0]
    points = np.stack([axis(name) for name in "xyz"], -1) if len(raw) else np.zeros((0, 3))
    return points, raw[:, fields["state"][0]] if "state" in fields else None


def compare(topic, time, message, wanted):
    what = f"{topic} at {time / 1e9:.2f} s"
    if hasattr(message, "header"):
        close(what + ", stamp", seconds(message.header.stamp), time / 1e9, 2e-9)
        same(what + ", frame", message.header.frame_id, "map")
    if topic == "/tf":
        same(what, [t.child_frame_id for t in message.transforms], [name for name, _ in wanted])
        for t, (name, pose) in zip(message.transforms, wanted):
            close(f"{what}, {name}", pose_of(t.transform), pose)
    elif topic == "/joint_states":
        same(what, list(message.name), wanted[0])
        close(what, message.position, wanted[1], 0)
    elif topic in ("/voxels", "/lidar", "/depth"):
        points, states = cloud_of(message)
        # float32 of up to 64 m.
        close(what, points, np.reshape(wanted[0], (-1, 3)), 4e-6)
        if wanted[1] is not None:
            close(what + ", states", states, wanted[1], 0)
    elif topic in ("/plan", "/camera_plan", "/horizon"):
        close(what, [[seconds(p.header.stamp)] + pose_of(p.pose) for p in message.poses], [[t] + list(p) for t, p in wanted], 2e-9)
    elif topic in ("/frontiers", "/viewpoints", "/tags", "/volumes"):
        same(what, [(m.ns, m.id, m.action) for m in message.markers], [w[:3] for w in wanted])
        for m, (_, _, _, place, points) in zip(message.markers, wanted):
            close(what, pose_of(m.pose)[:3], place)
            close(what, np.reshape([[p.x, p.y, p.z] for p in m.points], (-1, 3)), np.reshape(points, (-1, 3)))
    elif topic in ("/explored", "/inspected", "/success"):
        close(what, message.data, wanted, 1e-7)
    else:
        same(what, message.data, wanted)


def check(name, messages, topics, ground):
    """All messages of a reader, as (topic, time, message)."""
    counts, grid = defaultdict(int), None
    for topic, time, message in messages:
        if topic == "/map":
            grid = message
        else:
            if counts[topic] >= len(topics[topic]):
                sys.exit(f"{name}: too many messages on {topic}")
            due, wanted = topics[topic][counts[topic]]
            same(f"{name}: {topic}, time", time, due)
            compare(topic, time, message, wanted)
        counts[topic] += 1
    for topic, list_ in topics.items():
        same(f"{name}: messages on {topic}", counts[topic], len(list_))
    cells, nx, ny, size, low = ground
    same("map size", (grid.info.width, grid.info.height), (nx, ny))
    close("map resolution", grid.info.resolution, size, 1e-7)
    close("map origin", pose_of(grid.info.origin)[:2], low[:2])
    close("map cells", list(grid.data), cells, 0)
    print(f"{name}: {sum(counts.values())} messages on {len(counts)} topics are what was recorded")


def by_mcap(path):
    for m in read_ros2_messages(str(path)):
        yield m.channel.topic, m.log_time_ns, m.ros_msg


def by_rosbags(path, counts):
    """rosbags reads folders with a metadata.yaml, as ros2 bag writes them."""
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder)
        (bag / path.name).symlink_to(path.resolve())
        listed = [f"  - message_count: {n}\n    topic_metadata: {{name: {t}, type: {k}, serialization_format: cdr, offered_qos_profiles: ''}}" for t, k, n in counts]
        (bag / "metadata.yaml").write_text(
            "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  relative_file_paths: [%s]\n"
            "  duration: {nanoseconds: 1}\n  starting_time: {nanoseconds_since_epoch: 0}\n  message_count: %d\n"
            "  compression_format: ''\n  compression_mode: ''\n  topics_with_message_count:\n%s\n"
            % (path.name, sum(n for _, _, n in counts), "\n".join(listed)))
        with rosbags.rosbag2.Reader(bag) as reader:
            store = rosbags.typesys.get_typestore(rosbags.typesys.Stores.EMPTY)
            for c in reader.connections:
                store.register(rosbags.typesys.get_types_from_msg(c.msgdef.data, c.msgtype))
            for connection, time, raw in reader.messages():
                yield connection.topic, time, store.deserialize_cdr(raw, connection.msgtype)


def by_rerun(path, topics):
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "trace.rrd"
        program = Path(sysconfig.get_path("scripts")) / "rerun"
        subprocess.run([program, "mcap", "convert", "-o", made, path], check=True, capture_output=True)
        with rerun.server.Server(datasets={"trace": [str(made)]}) as server:
            data = server.client().get_dataset("trace")

            def column(topic, name):
                """Values by time in ns; of several at one time the last."""
                read = data.filter_contents([topic]).reader(index="message_log_time").select("message_log_time", f'"{topic}:{name}"')
                rows = read.to_arrow_table().to_pydict()
                times, values = rows["message_log_time"], rows[f"{topic}:{name}"]
                return {t.value if hasattr(t, "value") else round(t.timestamp() * 1e9): v for t, v in zip(times, values) if v is not None}

            count = 0
            checks = [
                ("/tf", "/tf", "Transform3D:translation", lambda w: [w[-1][1][:3]], 4e-6),
                ("/tf", "/tf", "Transform3D:quaternion", lambda w: [w[-1][1][3:]], 1e-6),
                ("/joint_states", "/joint_states/position", "Scalars:scalars", lambda w: w[1], 0),
                ("/lidar", "/lidar", "Points3D:positions", lambda w: w[0], 4e-6),
                ("/depth", "/depth", "Points3D:positions", lambda w: w[0], 4e-6),
                ("/voxels", "/voxels", "Points3D:positions", lambda w: w[0], 4e-6),
            ]
            for topic, entity, name, value, tolerance in checks:
                # Several messages at one time: Rerun's table has the last.
                wanted = dict(w for w in topics.get(topic, []) if len(value(w[1])))
                if not wanted:
                    continue
                got = column(entity, name)
                same(f"rerun: times of {topic}", sorted(got), sorted(wanted))
                for time, w in wanted.items():
                    close(f"rerun: {topic} at {time / 1e9:.2f} s", got[time], value(w), tolerance)
                    count += 1
    print(f"rerun: {count} transforms, joint states and clouds are what was recorded")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    trace = folder / "trace.mcap"
    topics, ground = expected(folder)
    check("mcap-ros2-support", by_mcap(trace), topics, ground)
    seen = defaultdict(lambda: [None, 0])
    for m in read_ros2_messages(str(trace)):
        seen[m.channel.topic][0] = m.schema.name
        seen[m.channel.topic][1] += 1
    check("rosbags", by_rosbags(trace, [(t, k, n) for t, (k, n) in seen.items()]), topics, ground)
    by_rerun(trace, topics)


if __name__ == "__main__":
    main()
