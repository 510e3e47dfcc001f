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


def submit_sh(job, claim, folder):
    """Exit code and output of submit.sh with a kubectl that runs containers here, and the folder of what it knows of jobs."""
    programs, state = folder / "programs", claim / ".state"
    for it in (programs, state):
        it.mkdir(exist_ok=True)
    (programs / "kubectl").write_text(f'#!/bin/sh\nexec "{sys.executable}" "{HERE / "pods.py"}" "$@"\n', encoding="utf-8")
    (programs / "kubectl").chmod(0o755)
    variables = {
        "PATH": f"{programs}:{os.environ['PATH']}", "KUBECTL_STATE": str(state), "CLAIM": str(claim),
        "IMAGE_PATH": f"{folder / 'image'}:/usr/bin:/bin",
    }
    command = ["bash", str(job / "submit.sh")]
    ended = subprocess.run(command, env=os.environ | variables, capture_output=True, text=True, check=False)
    logs = "".join(it.read_text(encoding="utf-8") for it in sorted(state.glob("*.log")))
    return ended.returncode, f"{ended.stdout}{ended.stderr}\n{logs}", state


def check_kubernetes(scanbench, whole, folder):
    (folder / "image").mkdir()
    (folder / "image/scanbench").symlink_to(scanbench)
    claim, broken, job = folder / "claim", folder / "broken", folder / "jobs/Fleet"
    for it in (claim, broken):
        shutil.copytree(folder / "fleet", it / DATA)
    options = ["--image", "scanbench:0.2", "--claim", "scans", "--shards", "3", "-o", str(job)]
    run([scanbench, "submit", "kubernetes", *options, "--", "run", DATA, *RUN], folder)
    versions = [check_schema(job / name) for name in ("shards.yaml", "merge.yaml")][0]
    code, output, _ = submit_sh(job, claim, folder)
    if code or "merged run: fleet/run" not in output:
        sys.exit(f"submit.sh: {code}\n{output}")
    same_run(whole, claim / "fleet" / "run")
    print(f"Kubernetes: manifests as the API has them from {versions[0]} to {versions[-1]}; 3 pods and a merge, the bytes of the whole run")

    # A shard that fails for good: no merge. Once the reason is gone, the same again.
    (broken / "fleet").write_text("in the way", encoding="utf-8")
    code, output, state = submit_sh(job, broken, folder)
    if code != 1 or "fleet-shards failed" not in output or (state / "fleet-merge").exists():
        sys.exit(f"submit.sh of a job that fails: {code}\n{output}")
    (broken / "fleet").unlink()
    shutil.rmtree(state)
    code, output, _ = submit_sh(job, broken, folder)
    if code:
        sys.exit(f"submit.sh, again: {code}\n{output}")
    same_run(whole, broken / "fleet" / "run")
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


def check_jobs(name, whole, folder, jobs, merge):
    """Runs each job, lines of a script and the variables of its environment, then the lines `merge`."""
    directory = workplace(name, folder)
    for lines, variables in [*jobs, (merge, {})]:
        for line in lines:
            run(["bash", "-eo", "pipefail", "-c", as_here(line)], directory, **variables)
    same_run(whole, directory / "runs" / "fleet")
    print(f"{name}: {len(jobs)} jobs and a merge, the bytes of the whole run")


def check_pipelines(whole, folder):
    gitlab, buildkite = (yaml.safe_load(it) for it in blocks("yaml"))
    n = gitlab["shards"]["parallel"]
    variables = [{"CI_NODE_INDEX": str(job + 1), "CI_NODE_TOTAL": str(n)} for job in range(n)]
    check_jobs("GitLab", whole, folder, [(gitlab["shards"]["script"], it) for it in variables], gitlab["merge"]["script"])
    shards, wait, merge = buildkite["steps"]
    assert wait == "wait" and merge["commands"][0].startswith("buildkite-agent artifact download"), merge
    n = shards["parallelism"]
    variables = [{"BUILDKITE_PARALLEL_JOB": str(job), "BUILDKITE_PARALLEL_JOB_COUNT": str(n)} for job in range(n)]
    # Buildkite makes one dollar of two.
    script = [shards["command"].replace("$$", "$")]
    check_jobs("Buildkite", whole, folder, [(script, it) for it in variables], merge["commands"][1:])


def check_workflow(name, language, file, words, whole, folder):
    """What the docs have for an engine that runs all of it by itself, where it is installed."""
    if shutil.which(name.lower()) is None:
        print(f"{name}: LEFT OUT, it is not installed")
        return
    directory = workplace(name, folder)
    [text] = blocks(language)
    (directory / file).write_text(as_here(text), encoding="utf-8")
    run([name.lower(), *words], directory)
    same_run(whole, directory / "runs" / "fleet")
    print(f"{name}: the {file} of the docs, the bytes of the whole run")


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
    check_workflow("Snakemake", "python", "Snakefile", ["--cores", "2", "--quiet"], whole, folder)
    check_workflow("Nextflow", "groovy", "main.nf", ["run", "main.nf"], whole, folder)


main()
