"""Scans of a bucket beside the same scans on disk: check.py SCANBENCH FOLDER

A server of S3 on this machine alone (moto) has a thousand small scans. Runs on the bucket and a run on the folder must give
the same rows. Prints how long each takes. Nothing leaves this machine, and the server ends with the check.
"""

import logging
import os
import shutil
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import boto3
from moto.server import ThreadedMotoServer

from program import run

N_SCANS, N_SCANS_SIMULATED = 1000, 50
KEYS = {"AWS_ACCESS_KEY_ID": "testing", "AWS_SECRET_ACCESS_KEY": "testing", "AWS_REGION": "us-east-1"}
# Whoever signs no request is let in, too.
PUBLIC = {"ACL": "public-read"}


def make_scans(scanbench, folder):
    """The files of drives, in which the same small scans come again and again."""
    street = ["street-narrow", "--sensor", "vlp-16", "--seed", 9001, "--simulated-scans", N_SCANS_SIMULATED]
    run(scanbench, "data", "simulate", *street, "--to", "semantic-kitti", "-o", folder)
    drives = sorted((folder / "sequences").iterdir())
    for copy in range(1, N_SCANS // N_SCANS_SIMULATED):
        for number, drive in enumerate(drives):
            shutil.copytree(drive, drive.with_name(f"{copy * len(drives) + number:02}"))
    return sorted(it for it in folder.rglob("*") if it.is_file())


def upload(files, folder, endpoint):
    client = boto3.client("s3", endpoint_url=endpoint, region_name=KEYS["AWS_REGION"],
                          aws_access_key_id=KEYS["AWS_ACCESS_KEY_ID"], aws_secret_access_key=KEYS["AWS_SECRET_ACCESS_KEY"])
    client.create_bucket(Bucket="scans", **PUBLIC)
    upload_one = lambda it: client.upload_file(str(it), "scans", f"drives/{it.relative_to(folder)}", ExtraArgs=PUBLIC)
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(upload_one, files))


def main(scanbench, scratch):
    # Without proxies and without whatever else of AWS the machine has.
    for name in [name for name in os.environ if "proxy" in name.lower() or name.startswith("AWS_")]:
        del os.environ[name]
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    scratch.mkdir(parents=True)
    folder, seconds = scratch / "drives", {}
    files = make_scans(scanbench, folder)
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    try:
        endpoint = "http://{}:{}".format(*server.get_host_and_port())
        upload(files, folder, endpoint)
        fetched, at = f"fetched {len(files)} of {len(files)} files", {"AWS_ENDPOINT_URL": endpoint}
        for name, data, cache, variables, says in [
            ("disk", folder, None, {}, ""),
            ("bucket", "s3://scans/drives", "cache", at | KEYS, fetched),
            ("bucket-again", "s3://scans/drives", "cache", at | KEYS, f"{len(files)} files as they are"),
            ("bucket-unsigned", "s3://scans/drives", "other", at | {"AWS_SKIP_SIGNATURE": "true"}, fetched),
        ]:
            began = time.monotonic()
            options = ["-d", "pca", "--no-rrd", "-o", scratch / name, *(["--cache", scratch / cache] if cache else [])]
            said = run(scanbench, "run", data, *options, environment=os.environ | variables)
            seconds[name] = time.monotonic() - began
            assert says in said, said
            assert (scratch / name / "matches.csv").read_bytes() == (scratch / "disk/matches.csv").read_bytes(), name
    finally:
        server.stop()
    n_bytes = sum(it.stat().st_size for it in files)
    print(f"{N_SCANS} scans, {len(files)} files, {n_bytes / 1e6:.1f} MB; the same rows from disk and bucket")
    for name, it in seconds.items():
        print(f"{name:<16} {it:6.1f} s, {it - seconds['disk']:+6.1f} s")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]))
