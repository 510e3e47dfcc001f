"""Recordings as the Python libraries of their makers read and write them, against what scanbench does."""

import json
from collections import Counter
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from mcap_ros2.writer import Writer as RosWriter

from converted import boxes, points
from program import rows

# The makers' own classes, to hold the descriptions that scanbench writes against.
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

OFFICIAL = {f"foxglove.{it.__name__}": it for it in (PointCloud, SceneUpdate, FrameTransform)}

POINT_CLOUD_2 = """std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: sensor_msgs/PointField
uint8 INT8=1
uint8 UINT8=2
uint8 INT16=3
uint8 UINT16=4
uint8 INT32=5
uint8 UINT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
string name
uint32 offset
uint8 datatype
uint32 count
"""


def check_written(scanbench, scratch: Path):
    """A simulated drive as a recording and as files of KITTI: the libraries find the same points and boxes in both."""
    for out, layout in [("narrow.mcap", "mcap"), ("narrow", "kitti-object")]:
        scanbench("data", "simulate", "training-narrow", "--simulated-scans", "3", "-o", scratch / out, "--to", layout)
    n_clouds = n_boxes = 0
    with open(scratch / "narrow.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert summary.statistics.message_count == 9 and summary.chunk_indexes, summary.statistics
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            official = OFFICIAL[schema.name]()
            official.ParseFromString(message.data)
            # Nothing that the makers' classes would not know, and the same for both descriptions.
            assert official.SerializeToString(deterministic=True) == decoded.SerializeToString(deterministic=True)
            if schema.name == "foxglove.PointCloud":
                names = [(field.name, field.offset, field.type) for field in official.fields]
                assert names[:4] == [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7)], names
                octets = np.frombuffer(official.data, np.uint8).reshape(-1, official.point_stride)
                assert np.array_equal(octets[:, :16].copy().view("<f4"), points(scratch / "narrow", n_clouds))
                n_clouds += 1
            if schema.name == "foxglove.SceneUpdate":
                labels = boxes(scratch / "narrow", n_clouds)
                for entity, (_, label) in zip(official.entities, labels, strict=True):
                    if not entity.cubes:
                        continue
                    at, size = entity.cubes[0].pose.position, entity.cubes[0].size
                    found = [at.x, at.y, at.z, size.x, size.y, size.z]
                    assert np.allclose(found, label[:6], atol=1e-4), (found, label)
                    n_boxes += 1
    assert n_clouds == 3 and n_boxes > 10
    metadata = next(iter(make_reader(open(scratch / "narrow.mcap", "rb")).iter_metadata()))
    assert json.loads(metadata.metadata["data_sheet"])["simulation"]["street"] == "street-narrow"
    return f"{n_clouds} clouds and {n_boxes} boxes read by mcap and foxglove-schemas-protobuf"


def check_results(scanbench, scratch: Path):
    """The recording of a run: as many messages and entities as rows of its CSV files, with the same outcomes and numbers."""
    scanbench("run", "training-narrow", "--simulated-scans", "3", "--no-rrd", "--mcap", "-o", scratch / "run")
    scans, matches = rows(scratch / "run/scans.csv"), rows(scratch / "run/matches.csv")
    key = lambda row: f"/{row['detector']}/{row['task']}"
    outcomes, numbers = Counter(), {}
    with open(scratch / "run/run.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert all(it.compression == "zstd" for it in summary.chunk_indexes) and summary.chunk_indexes
        # With indexes: only what is asked for is read.
        topics = [it.topic for it in summary.channels.values() if it.topic.count("/") == 3]
        for schema, channel, message in reader.iter_messages(topics=topics):
            detector_and_task, kind = channel.topic.rsplit("/", 1)
            if kind == "numbers":
                assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
                assert set(json.loads(schema.data)["properties"]) == set(json.loads(message.data))
                numbers.setdefault(detector_and_task, []).append(json.loads(message.data))
                continue
            scene = SceneUpdate()
            scene.ParseFromString(message.data)
            for entity in scene.entities:
                metadata = {it.key: it.value for it in entity.metadata}
                outcomes[detector_and_task, metadata["outcome"], metadata.get("reason", "")] += 1
                is_pair = metadata["outcome"] == "matched" or metadata.get("reason") == "tall"
                assert len(entity.cubes) == 1 and len(entity.lines) <= is_pair, metadata
                assert metadata["outcome"] != "matched" or entity.lines, metadata
    assert outcomes == Counter((key(row), row["outcome"], row["reason"]) for row in matches)
    assert sum(map(len, numbers.values())) == len(scans)
    for row in scans:
        number = numbers[key(row)].pop(0)
        assert all(str(number[it]) == row[it] for it in ("scan", "no", "tp", "mo", "fo"))
        # Times stand in the rows of tasks; those of classes have none.
        is_of_class = row["task"] not in ("objects", "vehicles")
        assert (row["latency_ms"] == "") == is_of_class == (number["latency_ms"] is None), row
        assert is_of_class or abs(number["latency_ms"] - float(row["latency_ms"])) < 1e-3
    return f"{len(scans)} rows of scans.csv and {len(matches)} of matches.csv found by mcap"


def check_read(scanbench, scratch: Path):
    """Clouds written by mcap-ros2-support: scanbench finds the same points."""
    random = np.random.default_rng(5)
    expected = []
    layout = [("z", "<f4", 0, 7), ("y", "<f4", 4, 7), ("ring", "<u2", 8, 4), ("intensity", "<f4", 12, 7)]
    layout.append(("x", "<f8", 16, 8))
    names, types, offsets, _ = zip(*layout)
    point = np.dtype({"names": names, "formats": types, "offsets": offsets, "itemsize": 24})
    with open(scratch / "ros.mcap", "wb") as stream:
        writer = RosWriter(stream)
        schema = writer.register_msgdef("sensor_msgs/msg/PointCloud2", POINT_CLOUD_2)
        for number in range(4):
            n_rows, n_columns = 16, 500 + number
            cloud = random.normal(0, 20, (n_rows * n_columns, 4)).astype("<f4")
            data = np.full(len(cloud), 7, point)
            data["x"], data["y"], data["z"], data["intensity"] = cloud.T
            message = {
                "header": {"stamp": {"sec": 0, "nanosec": number * 10**8}, "frame_id": "lidar"},
                "fields": [{"name": it[0], "offset": it[2], "datatype": it[3], "count": 1} for it in layout],
                "height": n_rows, "width": n_columns, "point_step": 24, "row_step": 24 * n_columns,
                "is_bigendian": False, "is_dense": True, "data": data.tobytes(),
            }  # fmt: skip
            times = {"log_time": number * 10**8, "publish_time": number * 10**8}
            writer.write_message("/top", schema, message, sequence=number, **times)
            expected.append(cloud)
        writer.finish()
    scanbench("data", "convert", scratch / "ros.mcap", "-o", scratch / "ros", "--to", "kitti-object")
    for number, cloud in enumerate(expected):
        assert np.array_equal(points(scratch / "ros", number), cloud)
    return f"{sum(map(len, expected))} points written by mcap-ros2-support"
