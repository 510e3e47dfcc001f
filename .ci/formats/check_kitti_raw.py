"""A drawn drive of KITTI's raw recordings as pykitti reads it, against what scanbench does."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pykitti
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from converted import assert_same, boxes, points

DATE, DRIVE = "2011_09_26", "0001"
CLASSES = {"Car": "Car", "Van": "Van", "Person (sitting)": "Person_sitting", "Misc": "Misc"}
N_SCANS = 12


def rotation(random):
    turn, _ = np.linalg.qr(np.eye(3) + random.normal(0, 0.01, (3, 3)))
    return turn * np.sign(np.diag(turn))


def write_scans(folder: Path, drive: Path, random):
    for name in ["velodyne_points/data", "oxts/data", *(f"image_0{it}/data" for it in range(4))]:
        (drive / name).mkdir(parents=True)
    to_camera = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]]) @ rotation(random)
    cameras = {"corner_dist": [0.0995]}
    for it in range(4):
        projection = [[721.5, 0, 609.6, 44.9 * it], [0, 721.5, 172.9, 0.2], [0, 0, 1, 0.003]]
        cameras |= {f"S_rect_0{it}": [1242, 375], f"R_rect_0{it}": rotation(random), f"P_rect_0{it}": projection}
    for name, values in [
        ("velo_to_cam", {"R": to_camera, "T": [0, -0.07, -0.27]}),
        ("imu_to_velo", {"R": rotation(random), "T": [-0.81, 0.32, -0.8]}),
        ("cam_to_cam", cameras),
    ]:
        lines = [f"{key}: {' '.join(map(repr, np.ravel(it).astype(float).tolist()))}" for key, it in values.items()]
        (folder / DATE / f"calib_{name}.txt").write_text("\n".join(["calib_time: 09-Jan-2012 13:57:47", *lines, ""]))
    for scan in range(N_SCANS):
        random.normal(0, 20, (2000, 4)).astype("<f4").tofile(drive / f"velodyne_points/data/{scan:010}.bin")
        position = [49.015 + 1e-5 * scan, 8.434 + 2e-5 * scan, 112 + 0.1 * scan]
        turn = [*random.normal(0, 0.1, 2).tolist(), random.uniform(-3, 3)]
        (drive / f"oxts/data/{scan:010}.txt").write_text(" ".join(map(repr, [*position, *turn, *[0.0] * 19, *[0] * 5])))
    times = "".join(f"2011-09-26 13:02:{25 + it // 10}.{it % 10}51199337\n" for it in range(N_SCANS))
    for name in ("velodyne_points", "oxts"):
        (drive / name / "timestamps.txt").write_text(times)


def write_labels(path: Path, random):
    """Tracklets; returns the boxes of each scan."""
    by_scan = [[] for _ in range(N_SCANS)]
    root = ElementTree.Element("boost_serialization", signature="serialization::archive", version="9")
    tracklets = ElementTree.SubElement(root, "tracklets")
    add = lambda to, **values: [setattr(ElementTree.SubElement(to, name), "text", str(it)) for name, it in values.items()]
    add(tracklets, count=12, item_version=1)
    for _ in range(12):
        item, name = ElementTree.SubElement(tracklets, "item"), random.choice(list(CLASSES))
        first, (height, width, length) = random.integers(0, N_SCANS), random.uniform(1, 5, 3)
        n_poses = random.integers(1, N_SCANS - first + 1)
        add(item, objectType=name, h=height, w=width, l=length, first_frame=first)
        poses = ElementTree.SubElement(item, "poses")
        add(poses, count=n_poses, item_version=2)
        for scan in range(first, first + n_poses):
            (x, y, z), yaw = random.uniform(-30, 30, 3), random.uniform(-3, 3)
            pose = ElementTree.SubElement(poses, "item")
            add(pose, tx=x, ty=y, tz=z, rx=0, ry=0, rz=yaw, state=2, occlusion=0, occlusion_kf=1, truncation=0)
            by_scan[scan].append((CLASSES[name], np.array([x, y, z + height / 2, length, width, height, yaw])))
        add(item, finished=1)
    head = '<?xml version="1.0" encoding="UTF-8" standalone="yes" ?>\n<!DOCTYPE boost_serialization>\n'
    path.write_text(head + ElementTree.tostring(root, encoding="unicode"))
    return by_scan


def check_read(scanbench, scratch: Path):
    random, raw, out = np.random.default_rng(17), scratch / "raw", scratch / "out"
    drive = raw / DATE / f"{DATE}_drive_{DRIVE}_sync"
    write_scans(raw, drive, random)
    labels = write_labels(drive / "tracklet_labels.xml", random)
    expected = pykitti.raw(str(raw), DATE, DRIVE)
    scanbench("data", "convert", raw, "-o", out, "--to", "kitti-object")
    scanbench("data", "convert", raw, "-o", scratch / "out.mcap")
    for scan, of_scan in enumerate(labels):
        assert np.array_equal(points(out, scan), expected.get_velo(scan))
        assert_same(boxes(out, scan), of_scan)
    with open(scratch / "out.mcap", "rb") as stream:
        messages = make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages(topics=["/tf"])
        poses = [(message.log_time, decoded) for _, _, message, decoded in messages]
    assert len(poses) == N_SCANS
    for scan, (time_ns, pose) in enumerate(poses):
        world_from_velodyne = expected.oxts[scan].T_w_imu @ np.linalg.inv(expected.calib.T_velo_imu)
        at, (x, y, z, w) = pose.translation, (getattr(pose.rotation, it) for it in "xyzw")
        assert np.allclose([at.x, at.y, at.z], world_from_velodyne[:3, 3], atol=1e-6)
        forward = [1 - 2 * (y**2 + z**2), 2 * (x * y + z * w), 2 * (x * z - y * w)]
        assert np.allclose(forward, world_from_velodyne[:3, 0], atol=1e-6)
        seconds = (expected.timestamps[scan] - expected.timestamps[0]).total_seconds()
        assert abs((time_ns - poses[0][0]) / 1e9 - seconds) < 1e-5
    # What the camera sees, by pykitti's calibration.
    [regions] = [it.read_bytes() for it in (out / "training").glob("point_region*/000000*")]
    cloud, calib = points(out, 0)[:, :3].astype("f8"), expected.calib
    image_from_velodyne = calib.P_rect_20 @ calib.R_rect_00 @ calib.T_cam0_velo_unrect
    in_camera = image_from_velodyne @ np.column_stack([cloud, np.ones(len(cloud))]).T
    pixels = in_camera[:2] / in_camera[2]
    seen = (in_camera[2] > 0) & (pixels >= 0).all(0) & (pixels[0] < 1242) & (pixels[1] < 375)
    pairs = set(zip(seen, regions, strict=True))
    assert len(pairs) == 2 and 50 < seen.sum() < 1000, pairs
    return f"{N_SCANS} scans, poses and views of a drawn drive as pykitti has them, {sum(map(len, labels))} boxes"
