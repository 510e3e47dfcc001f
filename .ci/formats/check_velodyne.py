"""Drawn packets as velodyne-decoder reads them, against what scanbench does."""

import struct
from importlib import resources
from pathlib import Path

import numpy as np
import velodyne_decoder

from converted import points

# Name, the model there, lasers of a block of a column, blocks of a column, the bytes at the end.
SENSORS = [
    ("vlp-16", velodyne_decoder.Model.VLP16, 1, b"\x37\x22"),
    ("hdl-32e", velodyne_decoder.Model.HDL32E, 1, b"\x37\x21"),
    ("hdl-64e", velodyne_decoder.Model.HDL64E_S2, 2, b"\x00\x00"),
]
N_TURNS, STEP = 3, 20


def packets(random, n_banks, last):
    """Whole turns from azimuth 0 on."""
    columns = np.arange(N_TURNS * 36000 // STEP) * STEP % 36000
    for column in columns.reshape(-1, 12 // n_banks):
        payload = b""
        for azimuth in column:
            for bank in [b"\xff\xee", b"\xff\xdd"][:n_banks]:
                distances = random.integers(500, 40000, 32) * (random.random(32) > 0.1)
                measured = zip(distances, random.integers(0, 256, 32))
                payload += bank + struct.pack("<H", azimuth) + b"".join(struct.pack("<HB", *it) for it in measured)
        yield payload + bytes(4) + last


def write(path: Path, payloads):
    with open(path, "wb") as stream:
        stream.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1))
        for number, payload in enumerate(payloads):
            udp = struct.pack(">HHHH", 2368, 2368, 8 + len(payload), 0) + payload
            addresses = bytes([192, 168, 1, 201, 255, 255, 255, 255])
            ip = struct.pack(">BBHHHBBH8s", 0x45, 0, 20 + len(udp), 0, 0x4000, 64, 17, 0, addresses)
            frame = bytes([255] * 12) + b"\x08\x00" + ip + udp
            micros = number * 1327
            stream.write(struct.pack("<IIII", 1600000000 + micros // 10**6, micros % 10**6, len(frame), len(frame)) + frame)


def check_read(scanbench, scratch: Path):
    random = np.random.default_rng(19)
    n_points = 0
    for name, model, n_banks, last in SENSORS:
        path = scratch / f"{name}.pcap"
        write(path, packets(random, n_banks, last))
        config = velodyne_decoder.Config(model=model, min_range=0, max_range=1000)
        if n_banks == 2:
            calibration = resources.files("velodyne_decoder") / "calibrations/HDL-64E_S2.1-sztaki.yml"
            path.with_suffix(".yml").write_text(calibration.read_text())
            config.calibration = velodyne_decoder.Calibration.read(str(path.with_suffix(".yml")))
        expected = np.vstack([cloud[:, :4] for _, cloud in velodyne_decoder.read_pcap(path, config)])
        scanbench("data", "convert", path, "-o", scratch / name, "--to", "kitti-object")
        found = np.vstack([points(scratch / name, number) for number in range(N_TURNS)])
        # There, the end of a capture belongs to no scan.
        assert len(expected) <= len(found) and len(expected) > 0.6 * len(found), (len(expected), len(found))
        found = found[: len(expected)]
        # There, angles are rounded to hundredths of a degree; lasers of the HDLs leave them centimetres beside the axis.
        off = np.abs(found[:, :3] - expected[:, :3])
        distance = np.linalg.norm(expected[:, :2], axis=1)
        beside = 0.05 if n_banks == 2 else 0.005
        assert (off[:, :2].max(1) < beside + np.radians(0.03) * distance).all(), (name, off.max(0))
        assert off[:, 2].max() < {"vlp-16": 0.003, "hdl-32e": 0.02, "hdl-64e": 0.05}[name], (name, off.max(0))
        if n_banks == 1:
            assert np.allclose(found[:, 3] * 255, expected[:, 3], atol=1e-3)
        n_points += len(found)
    return f"{n_points} points of {len(SENSORS)} sensors as velodyne-decoder has them"
