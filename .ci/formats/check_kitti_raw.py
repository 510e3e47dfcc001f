"""A drawn drive of KITTI's raw recordings as pykitti and ElementTree read it, against what scanbench does."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy
import pykitti
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from made_labels import assert_same, boxes, points

DATE, DRIVE = "2011_09_26", "0001"
CLASSES = {"Car": "Car", "Van": "Van", "Person (sitting)": "Person_sitting", "Misc": "Misc"}


def rotation(random, size):
    turn, _ = numpy.linalg.qr(numpy.eye(3) + random.normal(0, size, (3, 3)))
    return turn * numpy.sign(numpy.diag(turn))


def write(folder: Path, random, n_scans):
    drive = folder / DATE / f"{DATE}_drive_{DRIVE}_sync"
    for name in ["velodyne_points/data", "oxts/data", *(f"image_0{it}/data" for it in range(4))]:
        (drive / name).mkdir(parents=True)
    line = lambda name, values: f"{name}: {' '.join(map(repr, map(float, numpy.ravel(values))))}\n"
    to_camera = numpy.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]]) @ rotation(random, 0.01)
    time = "calib_time: 09-Jan-2012 13:57:47\n"
    (folder / DATE / "calib_velo_to_cam.txt").write_text(time + line("R", to_camera) + line("T", [0, -0.07, -0.27]))
    imu = line("R", rotation(random, 0.01)) + line("T", [-0.81, 0.32, -0.8])
    (folder / DATE / "calib_imu_to_velo.txt").write_text(time + imu)
    cameras = time + "corner_dist: 9.950000e-02\n"
    for it in range(4):
        projection = [[721.5, 0, 609.6, 44.9 * it], [0, 721.5, 172.9, 0.2], [0, 0, 1, 0.003]]
        cameras += line(f"S_rect_0{it}", [1242, 375]) + line(f"R_rect_0{it}", rotation(random, 0.01)) + line(f"P_rect_0{it}", projection)
    (folder / DATE / "calib_cam_to_cam.txt").write_text(cameras)
    for scan in range(n_scans):
        random.normal(0, 20, (2000, 4)).astype("<f4").tofile(drive / f"velodyne_points/data/{scan:010}.bin")
        position = [49.015 + 1e-5 * scan, 8.434 + 2e-5 * scan, 112 + 0.1 * scan, *random.normal(0, 0.1, 2), random.uniform(-3, 3)]
        (drive / f"oxts/data/{scan:010}.txt").write_text(" ".join(map(repr, [*map(float, position), *[0.0] * 19, *[0] * 5])))
    times = [f"2011-09-26 13:02:{25 + it // 10}.{it % 10}51199337\n" for it in range(n_scans)]
    (drive / "velodyne_points/timestamps.txt").write_text("".join(times))
    (drive / "oxts/timestamps.txt").write_text("".join(times))
    text = "<count>12</count><item_version>1</item_version>"
    for _ in range(12):
        height, width, length = random.uniform(1, 5, 3)
        first = random.integers(0, n_scans)
        n_poses = random.integers(1, n_scans - first + 1)
        text += f"<item><objectType>{random.choice(list(CLASSES))}</objectType><h>{height}</h><w>{width}</w><l>{length}</l>"
        text += f"<first_frame>{first}</first_frame><poses><count>{n_poses}</count><item_version>2</item_version>"
        for _ in range(n_poses):
            x, y, z = random.uniform(-30, 30, 3)
            text += f"<item><tx>{x}</tx><ty>{y}</ty><tz>{z}</tz><rx>0</rx><ry>0</ry><rz>{random.uniform(-3, 3)}</rz>"
            text += "<state>2</state><occlusion>0</occlusion><occlusion_kf>1</occlusion_kf><truncation>0</truncation></item>"
        text += "</poses><finished>1</finished></item>"
    head = '<?xml version="1.0" encoding="UTF-8" standalone="yes" ?>\n<!DOCTYPE boost_serialization>\n'
    tracklets = f'<boost_serialization signature="serialization::archive" version="9"><tracklets>{text}</tracklets></boost_serialization>'
    (drive / "tracklet_labels.xml").write_text(head + tracklets)
    return drive


def labels(drive: Path, n_scans):
    by_scan = [[] for _ in range(n_scans)]
    for item in ElementTree.parse(drive / "tracklet_labels.xml").getroot().find("tracklets").findall("item"):
        height, width, length = (float(item.find(name).text) for name in "hwl")
        for index, pose in enumerate(item.find("poses").findall("item")):
            x, y, z, yaw = (float(pose.find(name).text) for name in ["tx", "ty", "tz", "rz"])
            box = numpy.array([x, y, z + height / 2, length, width, height, yaw])
            by_scan[int(item.find("first_frame").text) + index].append((CLASSES[item.find("objectType").text], box))
    return by_scan


def check_read(scanbench, scratch: Path):
    n_scans = 12
    drive = write(scratch / "raw", numpy.random.default_rng(17), n_scans)
    expected = pykitti.raw(str(scratch / "raw"), DATE, DRIVE)
    scanbench("data", "convert", scratch / "raw", "-o", scratch / "out", "--to", "kitti-object")
    scanbench("data", "convert", scratch / "raw", "-o", scratch / "out.mcap")
    for scan, of_scan in enumerate(labels(drive, n_scans)):
        assert numpy.array_equal(points(scratch / "out", scan), expected.get_velo(scan))
        assert_same(boxes(scratch / f"out/training/label_2/{scan:06}.txt"), of_scan)
    with open(scratch / "out.mcap", "rb") as stream:
        messages = make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages(topics=["/tf"])
        poses = [(message.log_time, decoded) for _, _, message, decoded in messages]
    assert len(poses) == n_scans
    for scan, (time_ns, pose) in enumerate(poses):
        world_from_velodyne = expected.oxts[scan].T_w_imu @ numpy.linalg.inv(expected.calib.T_velo_imu)
        at, turn = pose.translation, pose.rotation
        assert numpy.allclose([at.x, at.y, at.z], world_from_velodyne[:3, 3], atol=1e-6)
        forward = [1 - 2 * (turn.y**2 + turn.z**2), 2 * (turn.x * turn.y + turn.z * turn.w), 2 * (turn.x * turn.z - turn.y * turn.w)]
        assert numpy.allclose(forward, world_from_velodyne[:3, 0], atol=1e-6)
        seconds = (numpy.datetime64(expected.timestamps[scan]) - numpy.datetime64(expected.timestamps[0])) / numpy.timedelta64(1, "s")
        assert abs((time_ns - poses[0][0]) / 1e9 - seconds) < 1e-5
    # What the camera sees, by pykitti's calibration.
    region = scratch / "out/training/point_region/000000.bin"
    regions = next((scratch / "out/training").glob("point_region*/000000*"), region).read_bytes()
    cloud = points(scratch / "out", 0)[:, :3].astype("f8")
    in_camera = expected.calib.P_rect_20 @ expected.calib.R_rect_00 @ expected.calib.T_cam0_velo_unrect @ numpy.column_stack([cloud, numpy.ones(len(cloud))]).T
    pixels = in_camera[:2] / in_camera[2]
    seen = (in_camera[2] > 0) & (pixels >= 0).all(0) & (pixels[0] < 1242) & (pixels[1] < 375)
    assert len(regions) == len(seen) and len(set(zip(seen, regions))) == 2 and 50 < seen.sum() < 1000, set(zip(seen, regions))
    return f"{n_scans} scans, poses and views of a drawn drive as pykitti has them, {sum(map(len, labels(drive, n_scans)))} boxes"
