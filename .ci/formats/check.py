"""Holds what scanbench reads and writes against other libraries; the step `formats` of .ci/run."""

import subprocess
import sys
import tempfile
from pathlib import Path

import check_argoverse2
import check_kitti_raw
import check_las
import check_mcap
import check_nuscenes
import check_results
import check_scan_folder
import check_velodyne

CHECKS = [
    ("MCAP, written", check_mcap.check_written),
    ("MCAP of results, written", check_mcap.check_results),
    ("MCAP, read", check_mcap.check_read),
    ("Argoverse 2, read", check_argoverse2.check_read),
    ("results in Argoverse 2's tables, read and written", check_results.check_tables),
    ("PCD, PLY and .npy, read", check_scan_folder.check_read),
    ("LAS and LAZ, read", check_las.check_read),
    ("KITTI raw, read", check_kitti_raw.check_read),
    ("nuScenes, read", check_nuscenes.check_read),
    ("captures of Velodyne's packets, read", check_velodyne.check_read),
]


def main():
    program = Path(sys.argv[1]).absolute()

    def scanbench(*arguments):
        ended = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
        assert ended.returncode == 0, f"{arguments}: {ended.stderr}"
        return ended.stdout

    for name, check in CHECKS:
        with tempfile.TemporaryDirectory() as scratch:
            print(f"ok  {name}: {check(scanbench, Path(scratch))}")


if __name__ == "__main__":
    main()
