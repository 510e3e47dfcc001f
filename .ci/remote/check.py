"""Scans of a bucket beside the same scans on disk: check.py SCANBENCH FOLDER [N_SCANS]

A server of S3 on this machine alone (moto) has N_SCANS small scans (a thousand if left out). Runs on the bucket and a run on the
folder must give the same rows. Prints how long each takes. Nothing leaves this machine, and the server ends with the check.
"""

import logging
import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import boto3
from moto.server import ThreadedMotoServer

N_SCANS_SIMULATED = 50
KEYS = {"AWS_ACCESS_KEY_ID": "testing", "AWS_SECRET_ACCESS_KEY": "testing", "AWS_REGION": "us-east-1"}
# The longest that a run may take, in seconds.
LONGEST_S = 3600
ADDRESS = "s3://scans/drives"


def is_left_out(name):
    return "proxy" in name.lower() or name.startswith("AWS_")


def environment(**variables):
    """Without proxies and without whatever else of AWS the machine has."""
    return {name: value for name, value in os.environ.items() if not is_left_out(name)} | variables


def timed(words, **variables):
    """Seconds that a command takes, which has to succeed, and what it says."""
    began = time.monotonic()
    ended = subprocess.run(
        [str(it) for it in words], env=environment(**variables), capture_output=True, text=True, check=False, timeout=LONGEST_S
    )
    if ended.returncode:
        sys.exit(f"{words}: {ended.returncode}\n{ended.stdout}{ended.stderr}")
    return time.monotonic() - began, ended.stderr


def make_scans(scanbench, folder, n_scans):
    """The files of drives, in which the same small scans come again and again."""
    simulate = ["data", "simulate", "street-narrow", "--sensor", "vlp-16", "--seed", 9001, "--to", "semantic-kitti"]
    timed([scanbench, *simulate, "--simulated-scans", N_SCANS_SIMULATED, "-o", folder])
    drives = sorted((folder / "sequences").iterdir())
    for copy in range(1, n_scans // N_SCANS_SIMULATED):
        for number, drive in enumerate(drives):
            shutil.copytree(drive, drive.with_name(f"{copy * len(drives) + number:02}"))
    return sorted(it for it in folder.rglob("*") if it.is_file())


def upload(files, folder, endpoint):
    client = boto3.client(
        "s3",
        endpoint_url=endpoint,
        region_name=KEYS["AWS_REGION"],
        aws_access_key_id=KEYS["AWS_ACCESS_KEY_ID"],
        aws_secret_access_key=KEYS["AWS_SECRET_ACCESS_KEY"],
    )
    # Whoever signs no request is let in, too.
    public = {"ACL": "public-read"}
    client.create_bucket(Bucket="scans", **public)
    upload = lambda it: client.upload_file(str(it), "scans", f"drives/{it.relative_to(folder)}", ExtraArgs=public)
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(upload, files))


def main():
    scanbench, scratch = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    n_scans = int(sys.argv[3]) if len(sys.argv) > 3 else 1000
    for name in [name for name in os.environ if is_left_out(name)]:
        del os.environ[name]
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    scratch.mkdir(parents=True)
    folder = scratch / "drives"
    files = make_scans(scanbench, folder, n_scans)
    n_bytes = sum(it.stat().st_size for it in files)
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    try:
        endpoint = "http://{}:{}".format(*server.get_host_and_port())
        upload(files, folder, endpoint)
        variables = {"AWS_ENDPOINT_URL": endpoint, **KEYS}
        seconds = {}

        def run(name, data, *options, **of_server):
            words = [scanbench, "run", data, "-d", "pca", "--no-rrd", "-o", scratch / name, *options]
            seconds[name], said = timed(words, **of_server)
            return said

        cache = ("--cache", scratch / "cache")
        run("disk", folder)
        fetched = run("bucket", ADDRESS, *cache, **variables)
        again = run("bucket-again", ADDRESS, *cache, **variables)
        unsigned = {"AWS_ENDPOINT_URL": endpoint, "AWS_SKIP_SIGNATURE": "true"}
        signless = run("bucket-unsigned", ADDRESS, "--cache", scratch / "other", **unsigned)
        assert f"fetched {len(files)} of {len(files)} files" in fetched, fetched
        assert f"fetched {len(files)} of {len(files)} files" in signless, signless
        assert f"{len(files)} files as they are" in again, again
        for name in seconds:
            assert (scratch / name / "matches.csv").read_bytes() == (scratch / "disk" / "matches.csv").read_bytes(), name
    finally:
        server.stop()
    print(f"{n_scans} scans, {len(files)} files, {n_bytes / 1e6:.1f} MB; the same rows from disk and bucket")
    for name, it in seconds.items():
        print(f"{name:<16} {it:6.1f} s, {it - seconds['disk']:+6.1f} s")


if __name__ == "__main__":
    main()
