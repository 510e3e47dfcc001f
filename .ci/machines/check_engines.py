"""What scanbench writes for engines, and what docs/many-machines.md says to their users: check_engines.py SCANBENCH FOLDER

Manifests against the schema of the API; shards and merges as containers, as parallel jobs of GitLab and Buildkite, and as rules of
Snakemake would run them. Each merged run is compared with the run without shards.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import kubernetes_validate
import yaml

HERE = Path(__file__).resolve().parent
# The release from which on an index may fail by itself: Kubernetes 1.29.
OLDEST_MINOR = 29
# A name that shells and Kubernetes take to pieces where it is not quoted.
DATA = "it's $(HOME) $$ data/fleet"
RUN = ["-d", "pca", "--no-rrd"] if os.environ.get("VIEWER", "1") == "1" else ["-d", "pca"]


def run(words, folder, **variables):
    """Output of a command that has to succeed."""
    ended = subprocess.run(
        words, cwd=folder, env=os.environ | variables, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if ended.returncode:
        sys.exit(f"{words} in {folder}: {ended.returncode}\n{ended.stdout}")
    return ended.stdout


def same_run(whole, merged):
    run([sys.executable, str(HERE / "same_run.py"), str(whole), str(merged)], ".")


def check_schema(path):
    manifest = yaml.safe_load(path.read_text(encoding="utf-8"))
    newest = int(kubernetes_validate.latest_version().split(".")[1])
    versions = [f"1.{minor}" for minor in range(OLDEST_MINOR, newest + 1)]
    assert len(versions) > 3, versions
    for version in versions:
        kubernetes_validate.validate(manifest, version, strict=True)
    wrong = path.read_text(encoding="utf-8").replace("template:", "templates:")
    try:
        kubernetes_validate.validate(yaml.safe_load(wrong), versions[-1], strict=True)
    except kubernetes_validate.ValidationError:
        return versions
    sys.exit(f"{path}: a wrong name is not seen")


def submit_sh(job, claim, state, folder):
    """Exit code and output of submit.sh with a kubectl that runs containers here."""
    programs = folder / "programs"
    programs.mkdir(exist_ok=True)
    (programs / "kubectl").write_text(f'#!/bin/sh\nexec "{sys.executable}" "{HERE / "pods.py"}" "$@"\n', encoding="utf-8")
    (programs / "kubectl").chmod(0o755)
    state.mkdir(exist_ok=True)
    image = folder / "image"
    variables = {
        "PATH": f"{programs}:{os.environ['PATH']}", "KUBECTL_STATE": str(state), "CLAIM": str(claim),
        "IMAGE_PATH": f"{image}:/usr/bin:/bin",
    }
    ended = subprocess.run(
        ["bash", str(job / "submit.sh")], env=os.environ | variables, capture_output=True, text=True, check=False
    )
    return ended.returncode, ended.stdout + ended.stderr


def check_kubernetes(scanbench, whole, folder):
    claim = folder / "claim"
    claim.mkdir()
    shutil.copytree(folder / "fleet", claim / DATA)
    image = folder / "image"
    image.mkdir()
    (image / "scanbench").symlink_to(scanbench)
    job = folder / "jobs" / "Fleet"
    run(
        [scanbench, "submit", "kubernetes", "--image", "scanbench:0.2", "--claim", "scans", "--shards", "3", "-o", str(job), "--",
         "run", DATA, *RUN],
        folder,
    )
    versions = [check_schema(job / name) for name in ("shards.yaml", "merge.yaml")][0]
    code, output = submit_sh(job, claim, folder / "state", folder)
    if code or "merged run: fleet/run" not in output:
        logs = "".join(it.read_text(encoding="utf-8") for it in sorted((folder / "state").glob("*.log")))
        sys.exit(f"submit.sh: {code}\n{output}\n{logs}")
    same_run(whole, claim / "fleet" / "run")
    print(f"Kubernetes: manifests as the API has them from {versions[0]} to {versions[-1]}; 3 pods and a merge, the bytes of the whole run")

    # A shard that fails for good: no merge. Once the reason is gone, the same again.
    claim = folder / "broken"
    claim.mkdir()
    (claim / "fleet").write_text("in the way", encoding="utf-8")
    shutil.copytree(folder / "fleet", claim / DATA)
    code, output = submit_sh(job, claim, folder / "state-broken", folder)
    if code != 1 or "fleet-shards failed" not in output or (folder / "state-broken" / "fleet-merge").exists():
        sys.exit(f"submit.sh of a job that fails: {code}\n{output}")
    (claim / "fleet").unlink()
    shutil.rmtree(folder / "state-broken")
    code, output = submit_sh(job, claim, folder / "state-broken", folder)
    if code:
        sys.exit(f"submit.sh, again: {code}\n{output}")
    same_run(whole, claim / "fleet" / "run")
    print("Kubernetes: where shards fail, nothing is merged; the same submission again merges")


def blocks(language):
    """The fenced blocks of docs/many-machines.md in a language."""
    text = (HERE.parent.parent / "docs" / "many-machines.md").read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def as_here(command):
    """A command of the docs, with the detector and the options of the run that it is compared with."""
    return command.replace("-d hierarchical", " ".join(RUN))


def workplace(name, folder):
    directory = folder / name
    (directory / "data").mkdir(parents=True)
    shutil.copytree(folder / "fleet", directory / "data" / "fleet")
    return directory


def check_parallel(name, whole, folder, n_jobs, of_job, shard, merge):
    """Runs the lines `shard` as each of `n_jobs` jobs with the variables `of_job` of it, then the lines `merge`."""
    directory = workplace(name, folder)
    for job in range(n_jobs):
        for line in shard:
            run(["bash", "-eo", "pipefail", "-c", as_here(line)], directory, **of_job(job))
    for line in merge:
        run(["bash", "-eo", "pipefail", "-c", as_here(line)], directory)
    same_run(whole, directory / "runs" / "fleet")
    print(f"{name}: {n_jobs} jobs and a merge, the bytes of the whole run")


def check_pipelines(whole, folder):
    gitlab, buildkite = (yaml.safe_load(it) for it in blocks("yaml"))
    n_jobs = gitlab["shards"]["parallel"]
    check_parallel(
        "GitLab", whole, folder, n_jobs,
        lambda job: {"CI_NODE_INDEX": str(job + 1), "CI_NODE_TOTAL": str(n_jobs)},
        gitlab["shards"]["script"], gitlab["merge"]["script"],
    )
    shards, wait, merge = buildkite["steps"]
    assert wait == "wait" and merge["commands"][0].startswith("buildkite-agent artifact download"), merge
    n_jobs = shards["parallelism"]
    check_parallel(
        "Buildkite", whole, folder, n_jobs,
        lambda job: {"BUILDKITE_PARALLEL_JOB": str(job), "BUILDKITE_PARALLEL_JOB_COUNT": str(n_jobs)},
        # Buildkite makes one dollar of two.
        [shards["command"].replace("$$", "$")], merge["commands"][1:],
    )


def check_snakemake(whole, folder):
    snakemake = shutil.which("snakemake")
    if snakemake is None:
        print("Snakemake: LEFT OUT, it is not installed")
        return
    directory = workplace("Snakemake", folder)
    [snakefile] = blocks("python")
    (directory / "Snakefile").write_text(as_here(snakefile), encoding="utf-8")
    run([snakemake, "--cores", "2", "--quiet"], directory)
    same_run(whole, directory / "runs" / "fleet")
    print("Snakemake: the rules of the docs, the bytes of the whole run")


def check_nextflow(whole, folder):
    nextflow = shutil.which("nextflow")
    if nextflow is None:
        print("Nextflow: LEFT OUT, it is not installed")
        return
    directory = workplace("Nextflow", folder)
    [pipeline] = blocks("groovy")
    (directory / "main.nf").write_text(as_here(pipeline), encoding="utf-8")
    run([nextflow, "run", "main.nf"], directory)
    same_run(whole, directory / "runs" / "fleet")
    print("Nextflow: the processes of the docs, the bytes of the whole run")


def main():
    scanbench, folder = sys.argv[1], Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True)
    os.environ["PATH"] = f"{Path(scanbench).resolve().parent}:{os.environ['PATH']}"
    run([scanbench, "data", "simulate", "street-narrow", "--simulated-scans", "24", "--sensor", "hdl-32e",
         "--to", "kitti-tracking", "-o", "fleet"], folder)
    run([scanbench, "run", "fleet", *RUN, "-o", "whole"], folder)
    whole = folder / "whole"
    check_kubernetes(scanbench, whole, folder)
    check_pipelines(whole, folder)
    check_snakemake(whole, folder)
    check_nextflow(whole, folder)


main()
