"""What scanbench writes for engines, and what docs/many-machines.md says to their users: check_engines.py SCANBENCH FOLDER

Manifests against the schema of the API; shards and merges as containers, as parallel jobs of GitLab and Buildkite, and as
rules of Snakemake would run them. Each merged run is compared with the run without shards.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import kubernetes_validate
import yaml

from program import run

HERE = Path(__file__).resolve().parent
# The release from which on an index may fail by itself: Kubernetes 1.29.
OLDEST_MINOR = 29
# A name that shells and Kubernetes take to pieces where it is not quoted.
DATA = "it's $(HOME) $$ data/fleet"
RUN = ["-d", "pca", "--no-rrd"]


def same_run(folder, merged):
    run(sys.executable, HERE / "same_run.py", folder / "whole", merged)


def check_schema(path):
    text = path.read_text(encoding="utf-8")
    newest = int(kubernetes_validate.latest_version().split(".")[1])
    versions = [f"1.{minor}" for minor in range(OLDEST_MINOR, newest + 1)]
    assert len(versions) > 3, versions
    for version in versions:
        kubernetes_validate.validate(yaml.safe_load(text), version, strict=True)
    try:
        kubernetes_validate.validate(yaml.safe_load(text.replace("template:", "templates:")), versions[-1], strict=True)
    except kubernetes_validate.ValidationError:
        return versions
    sys.exit(f"{path}: a wrong name is not seen")


def check_kubernetes(scanbench, folder):
    (folder / "image").mkdir()
    (folder / "image/scanbench").symlink_to(scanbench)
    claim, broken, job = folder / "claim", folder / "broken", folder / "jobs/Fleet"
    for it in (claim, broken):
        shutil.copytree(folder / "fleet", it / DATA)
        (it / ".state").mkdir()
    options = ["--image", "scanbench:0.2", "--claim", "scans", "--shards", "3", "-o", str(job)]
    run(scanbench, "submit", "kubernetes", *options, "--", "run", DATA, *RUN, cwd=folder)
    versions = [check_schema(job / name) for name in ("shards.yaml", "merge.yaml")][0]

    def submit(claim, expected_code, says=""):
        """submit.sh with a kubectl that runs containers here."""
        state = claim / ".state"
        variables = {"PATH": f"{HERE}:{os.environ['PATH']}", "KUBECTL_STATE": str(state), "CLAIM": str(claim)}
        variables["IMAGE_PATH"] = f"{folder / 'image'}:/usr/bin:/bin"
        command = ["bash", str(job / "submit.sh")]
        ended = subprocess.run(command, env=os.environ | variables, capture_output=True, text=True, check=False)
        logs = "".join(it.read_text(encoding="utf-8") for it in sorted(state.glob("*.log")))
        if ended.returncode != expected_code or says not in (output := f"{ended.stdout}{ended.stderr}\n{logs}"):
            sys.exit(f"submit.sh: {ended.returncode}\n{output}")
        if expected_code == 0:
            same_run(folder, claim / "fleet/run")

    submit(claim, 0, "merged run: fleet/run")
    api = f"manifests as the API has them from {versions[0]} to {versions[-1]}"
    print(f"Kubernetes: {api}; 3 pods and a merge, the bytes of the whole run")
    # A shard that fails for good: no merge. Once the reason is gone, the same again.
    (broken / "fleet").write_text("in the way", encoding="utf-8")
    submit(broken, 1, "fleet-shards failed")
    assert not (broken / ".state/fleet-merge").exists()
    (broken / "fleet").unlink()
    for it in (broken / ".state").iterdir():
        it.unlink()
    submit(broken, 0)
    print("Kubernetes: where shards fail, nothing is merged; the same submission again merges")


def blocks(language):
    """The fenced blocks of docs/many-machines.md in a language."""
    text = (HERE.parent.parent / "docs" / "many-machines.md").read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def as_here(command):
    """A command of the docs, with the detector and the options of the run that it is compared with."""
    return command.replace("-d hierarchical", " ".join(RUN))


def workplace(name, folder):
    shutil.copytree(folder / "fleet", folder / name / "data" / "fleet")
    return folder / name


def check_jobs(name, folder, script, jobs, merge):
    """Runs the lines of a script with the variables of each job, then the lines `merge`."""
    directory = workplace(name, folder)
    for lines, variables in [*((script, it) for it in jobs), (merge, {})]:
        for line in lines:
            run("bash", "-eo", "pipefail", "-c", as_here(line), cwd=directory, environment=os.environ | variables)
    same_run(folder, directory / "runs" / "fleet")
    print(f"{name}: {len(jobs)} jobs and a merge, the bytes of the whole run")


def check_pipelines(folder):
    gitlab, buildkite = (yaml.safe_load(it) for it in blocks("yaml"))
    n = gitlab["shards"]["parallel"]
    jobs = [{"CI_NODE_INDEX": str(job + 1), "CI_NODE_TOTAL": str(n)} for job in range(n)]
    check_jobs("GitLab", folder, gitlab["shards"]["script"], jobs, gitlab["merge"]["script"])
    shards, wait, merge = buildkite["steps"]
    assert wait == "wait" and merge["commands"][0].startswith("buildkite-agent artifact download"), merge
    n = shards["parallelism"]
    jobs = [{"BUILDKITE_PARALLEL_JOB": str(job), "BUILDKITE_PARALLEL_JOB_COUNT": str(n)} for job in range(n)]
    # Buildkite makes one dollar of two.
    check_jobs("Buildkite", folder, [shards["command"].replace("$$", "$")], jobs, merge["commands"][1:])


def check_workflow(name, language, file, words, folder):
    """What the docs have for an engine that runs all of it by itself, where it is installed."""
    if shutil.which(name.lower()) is None:
        print(f"{name}: LEFT OUT, it is not installed")
        return
    directory = workplace(name, folder)
    [text] = blocks(language)
    (directory / file).write_text(as_here(text), encoding="utf-8")
    run(name.lower(), *words, cwd=directory)
    same_run(folder, directory / "runs" / "fleet")
    print(f"{name}: the {file} of the docs, the bytes of the whole run")


def main():
    scanbench, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True)
    os.environ["PATH"] = f"{scanbench.parent}:{os.environ['PATH']}"
    street = ["street-narrow", "--simulated-scans", "24", "--sensor", "hdl-32e", "--to", "kitti-tracking"]
    run(scanbench, "data", "simulate", *street, "-o", "fleet", cwd=folder)
    run(scanbench, "run", "fleet", *RUN, "-o", "whole", cwd=folder)
    check_kubernetes(scanbench, folder)
    check_pipelines(folder)
    check_workflow("Snakemake", "python", "Snakefile", ["--cores", "2", "--quiet"], folder)
    check_workflow("Nextflow", "groovy", "main.nf", ["run", "main.nf"], folder)


main()
