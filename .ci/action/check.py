"""Does what CI servers do with the action, the job for GitLab and the written workflow: check.py SCANBENCH WORKSPACE

Every step is taken from its file, with the environment that the server would give it. What is fetched from elsewhere, such
as other actions and wheels, is not: an upload only has to find its files.
"""

import hashlib
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import yaml

from program import read_json

ROOT = Path(__file__).resolve().parents[2]
GATE = ROOT / ".github/action/gate.sh"
# Ten drives of few beams: enough for a loss to be sure.
SCANS = "street-narrow --simulated-scans 20 --scans 0..20:2 --sensor vlp-16 -d 'pca'"
PAGES = ("run/report.html", "run/recording/layout.rrd", "verdict/gate.json", "verdict/junit.xml", "gate.txt")


@dataclass
class Job:
    """What came of the steps."""

    code: int = 0
    said: str = ""
    summary: str = ""
    outputs: dict[str, str] = field(default_factory=dict)
    uploaded: list[str] = field(default_factory=list)


class Server:
    """A folder, and a program on the PATH."""

    def __init__(self, program: Path, workspace: Path):
        self.workspace, programs = workspace, workspace / ".bin"
        programs.mkdir(parents=True)
        (programs / "scanbench").symlink_to(program.resolve())
        self.path = f"{programs}:{os.environ['PATH']}"

    def bash(self, script: str, **variables: str) -> subprocess.CompletedProcess[str]:
        names = {"HOME", "LANG", "CARGO_HOME", "RUSTUP_HOME", "CARGO_TARGET_DIR"}
        kept = {name: value for name, value in os.environ.items() if name in names}
        command = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script]
        environment = kept | {"PATH": self.path} | variables
        return subprocess.run(command, cwd=self.workspace, env=environment, capture_output=True, text=True, check=False)

    def action(self, **given: str) -> Job:
        """The steps of action.yml, with these inputs."""
        action = yaml.safe_load((ROOT / "action.yml").read_text())
        given = {name.replace("_", "-"): value for name, value in given.items()}
        assert given.keys() <= action["inputs"].keys(), given
        inputs = {name: given.get(name, spec.get("default")) for name, spec in action["inputs"].items()}
        assert None not in inputs.values(), f"required: {inputs}"
        values = {f"inputs.{name}": value for name, value in inputs.items()}
        files = {it: self.workspace / f".{it.lower()}" for it in ("GITHUB_STEP_SUMMARY", "GITHUB_PATH", "GITHUB_OUTPUT")}
        for file in files.values():
            file.write_text("")
        variables = {"GITHUB_ACTIONS": "true", "GITHUB_ACTION_PATH": str(ROOT), "GITHUB_WORKSPACE": str(self.workspace)}
        variables |= {name: str(file) for name, file in files.items()}
        job, of_steps = Job(), {}
        for step in action["runs"]["steps"]:
            if job.code and step.get("if") != "always()":
                continue
            if "uses" in step:
                if step["uses"].startswith("actions/upload-artifact@"):
                    job.uploaded = expanded(step["with"]["path"], values).splitlines()
                continue
            assert "${{" not in step["run"], "what users write belongs into the environment"
            files["GITHUB_OUTPUT"].write_text("")
            own = {name: expanded(value, values) for name, value in step.get("env", {}).items()}
            ended = self.bash(step["run"], **own, **variables)
            job.code, job.said = ended.returncode, job.said + ended.stdout + ended.stderr
            for line in files["GITHUB_OUTPUT"].read_text().splitlines():
                name, value = line.split("=", 1)
                of_steps[f"steps.{step['id']}.outputs.{name}"] = value
        job.summary = files["GITHUB_STEP_SUMMARY"].read_text()
        job.outputs = {name: expanded(it["value"], of_steps, "") for name, it in action["outputs"].items()}
        return job

    def check_artifacts(self, paths: list[str]) -> None:
        assert paths and all((self.workspace / it).exists() for it in paths), paths


def expanded(text: str, values: dict[str, str], absent: str | None = None) -> str:
    value = lambda found: values[found[1]] if absent is None else values.get(found[1], absent)
    return re.sub(r"\$\{\{ *([^} ]+) *\}\}", value, text)


def check_passed(ended: subprocess.CompletedProcess[str]) -> None:
    assert ended.returncode == 0 and "\nPASSED\n" in f"\n{ended.stdout}", ended


def check_verdict(server: Server, code: int, headline: str, **given: str) -> None:
    """Whatever it comes to, the summary says it, and page, recording and verdict are uploaded."""
    job = server.action(baseline="first", **given)
    assert job.code == code, f"exit code {job.code} instead of {code}\n{job.said}"
    assert re.fullmatch(headline, job.outputs["headline"]), job.outputs
    assert job.outputs["exit-code"] == str(code), job.outputs
    assert job.summary.startswith(f"## scanbench\n\n**{job.outputs['headline']}**\n"), job.summary
    [folder] = job.uploaded
    server.check_artifacts([job.outputs["page"], *(f"{folder}/{it}" for it in PAGES)])

    # The files of the verdict as others read them: JUnit, github-action-benchmark, Bencher.
    directory = server.workspace / folder / "verdict"
    verdict, entries, benchmarks = (
        read_json(directory / f"{it}.json") for it in ("gate", "custom-smaller-is-better", "bencher")
    )
    findings = [it["finding"] for it in verdict["metrics"] + verdict["speeds"]]
    n_drift = len(verdict["drift"])
    n_allowed = n_drift if verdict["drift_rule"] == "warn" else 0
    junit = ElementTree.parse(directory / "junit.xml").getroot()
    n_skipped = findings.count("inconclusive") + n_allowed + bool(verdict["speed_not_compared"])
    assert len(junit.findall(".//skipped")) == n_skipped, n_skipped
    n_failed = findings.count("regression") + n_drift - n_allowed
    assert len(junit.findall(".//failure")) == int(junit.attrib["failures"]) == n_failed, n_failed
    assert len(junit.findall(".//testcase[@name][@classname]")) == int(junit.attrib["tests"]) > 0
    assert len({it["name"] for it in entries}) == len(entries) > 0, entries
    for it in entries:
        assert it["value"] >= 0 and it["unit"] and set(it) <= {"name", "unit", "value", "range", "extra"}, it
    for it in (measure for measures in benchmarks.values() for measure in measures.values()):
        assert it.get("lower_value", it["value"]) <= it["value"] <= it.get("upper_value", it["value"]), it


def check_action(server: Server) -> None:
    (server.workspace / "warn.toml").write_text(
        'drift = "warn"\n[[quality]]\nmetrics = ["recall"]\nslices = ["all"]\nabsolute = 0.1\nrelative = 0.0\n'
    )
    changed, allowed = f"{SCANS} -P pca.cluster.min_points=16", r"PASSED, results changed on \d+ scans? \(allowed\)"
    for run, code, headline, more in (
        (SCANS, 0, "PASSED", {}),
        (f"{SCANS} -P pca.cluster.min_points=200", 100, "FAILED: worse", {"output": "out/worse"}),
        (changed, 101, "FAILED: results changed", {}),
        (changed, 0, allowed, {"allow_drift": "true"}),
        (changed, 0, allowed, {"tolerances": "warn.toml"}),
        (changed, 101, ".* changed", {"tolerances": "warn.toml", "allow_drift": "false"}),
    ):
        check_verdict(server, code, headline, run=run, **more)
    # A run that fails is not gated, and what looks like a command is a word.
    failed = server.action(run="no-such-street '$(touch owned)' $(touch owned)", baseline="first")
    assert not (server.workspace / "owned").exists()
    assert failed.code == 2 and "headline" in failed.outputs and not failed.outputs["headline"], failed
    assert failed.uploaded, "what there is of it is uploaded"
    # No other run in its place: a quote that is not closed ends it.
    torn = server.action(run=f"{SCANS} -P pca.name='a", baseline="first", output="out/torn")
    assert torn.code == 1 and "quote" in torn.said and not (server.workspace / "out/torn").exists(), torn


def check_install(server: Server) -> None:
    """A wheel, the program of a release by its checksum alone, or what is built: by programs that stand in for others."""
    stand_ins = server.workspace / ".stand-ins"
    (stand_ins / "scanbench-1").mkdir(parents=True)
    target, noted, added = stand_ins / "target", stand_ins / "noted", stand_ins / "added"
    note = f'echo "$(basename "$0") $* in $PWD" >> {noted}'
    for name, program in {
        "scanbench-1/scanbench": "echo scanbench of the release",
        # It may be of another version, and does not take the place of the source.
        "scanbench": "echo found on the PATH",
        "python3": note,
        "curl": f'for it; do :; done\ncp "{stand_ins}/$(basename "$it")" "${{@:$#-1:1}}"',
        "cargo": f'{note}\nmkdir -p {target}/release\nprintf "#!/bin/sh\\necho built\\n" > {target}/release/scanbench\n'
        f"chmod +x {target}/release/scanbench",
    }.items():
        (stand_ins / name).write_text(f"#!/bin/bash\n{program}\n")
        (stand_ins / name).chmod(0o755)
    archive = stand_ins / "a release.tar.gz"
    subprocess.run(["tar", "-czf", archive, "-C", stand_ins, "scanbench-1"], check=True)
    own = hashlib.sha256(archive.read_bytes()).hexdigest()
    pip = f"python3 -m pip install --quiet --disable-pip-version-check a wheel.whl in {server.workspace}\n"
    build = f"cargo build --release --locked in {ROOT}\n"
    released, there = "scanbench of the release\n", f"{stand_ins}/temporary/scanbench-{own}\n"
    built = f"{target}/release\n"
    for given, code, said, done, found_in in (
        ({}, 0, "built\n", build, built),
        ({"WHEEL": "a wheel.whl"}, 0, "found on the PATH\n", pip, ""),
        # A name alone would be looked up on a package index, where anybody may have taken it.
        ({"WHEEL": "scanbench"}, 2, "wheel is not pinned: scanbench\n", "", ""),
        ({"ARCHIVE": f".stand-ins/a release.tar.gz#sha256={own}"}, 0, released, "", there),
        ({"ARCHIVE": f"https://example.org/a release.tar.gz#sha256={own}"}, 0, released, "", there),
        ({"ARCHIVE": f"https://example.org/none.tar.gz#sha256={own}"}, 0, "built\n", build, built),
        ({"ARCHIVE": f".stand-ins/none.tar.gz#sha256={own}"}, 0, "built\n", build, built),
        ({"ARCHIVE": f".stand-ins/a release.tar.gz#sha256={own[::-1]}"}, 2, "did NOT match\n", "", ""),
        ({"ARCHIVE": f"http://example.org/a release.tar.gz#sha256={own}"}, 2, "archive is not pinned: http://", "", ""),
        ({"ARCHIVE": ".stand-ins/a release.tar.gz"}, 2, "archive is not pinned: .stand-ins/a release.tar.gz\n", "", ""),
    ):
        for it in (noted, added):
            it.write_text("")
        variables = {"PATH": f"{stand_ins}:/usr/bin:/bin", "CARGO_TARGET_DIR": str(target), "GITHUB_PATH": str(added)}
        ended = server.bash(f"{GATE} install", **variables, RUNNER_TEMP=str(stand_ins / "temporary"), **given)
        is_said = ended.stdout == said if code == 0 else not ended.stdout and said in ended.stderr
        assert ended.returncode == code and is_said, (given, ended)
        assert (noted.read_text(), added.read_text()) == (done, found_in), (given, noted.read_text(), added.read_text())
        shutil.rmtree(stand_ins / "temporary", ignore_errors=True)
    assert server.bash(f"{GATE} instal").returncode == 2
    assert "the folder of the baseline" in server.bash(f"{GATE} gate").stderr


def check_gitlab(server: Server) -> None:
    job = yaml.safe_load((ROOT / ".gitlab/gate.yml").read_text())["scanbench"]
    variables = job["variables"] | {"RUN": SCANS.replace("'", ""), "BASELINE": "first"}
    [install, *script] = job["script"]
    assert "pip install" in install
    ended = server.bash(install, **variables)
    assert ended.returncode and "the path or address of a wheel" in ended.stderr, ended
    check_passed(server.bash("\n".join(script), **variables))
    server.check_artifacts([*job["artifacts"]["paths"], job["artifacts"]["reports"]["junit"]])


def check_written_workflow(server: Server) -> None:
    manifest = server.workspace / "first/manifest.json"
    # Whoever changes the program runs this before there is a commit of it.
    manifest.write_text(manifest.read_text().replace('"dirty": true', '"dirty": false'))
    ended = server.bash("scanbench baseline init first -o ci")
    assert ended.returncode == 0, ended
    steps = yaml.safe_load((server.workspace / "ci/scanbench.yml").read_text())["jobs"]["gate"]["steps"]
    [install, *scripts] = sorted((it["run"] for it in steps if "run" in it), key=lambda it: "pip install" not in it)
    ended = server.bash(install, WHEEL="")
    assert "pip install" in install and ended.returncode and "SCANBENCH_WHEEL" in ended.stderr, ended
    assert len(scripts) == 2 and "pip install" not in "".join(scripts), scripts
    check_passed(server.bash("\n".join(scripts)))
    [upload] = [it for it in steps if it.get("uses", "").startswith("actions/upload-artifact@")]
    server.check_artifacts(upload["with"]["path"].splitlines())


def main() -> None:
    program, workspace = map(Path, sys.argv[1:])
    workspace.mkdir(parents=True)
    server = Server(program, workspace.resolve())
    ended = server.bash(f"scanbench run {SCANS} -o first")
    assert ended.returncode == 0, ended
    for check in [check_action, check_install, check_gitlab, check_written_workflow]:
        check(server)
        shutil.rmtree(server.workspace / "runs", ignore_errors=True)
        print(f"{check.__name__.removeprefix('check_').replace('_', ' ')}: as it should be")


main()
