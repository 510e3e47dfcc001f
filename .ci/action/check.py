"""Does what CI servers do with the action, the job for GitLab and the written workflow: check.py SCANBENCH WORKSPACE

Every step is taken from its file, with the environment that the server would give it. What is fetched from elsewhere, such as other
actions and wheels, is not: an upload only has to find its files.
"""

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import yaml

ROOT = Path(__file__).resolve().parents[2]
BASH = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c"]
# Ten drives of few beams: enough for a loss to be sure.
SCANS = "street-narrow --simulated-scans 20 --scans 0..20:2 --sensor vlp-16 -d 'pca'"


@dataclass
class Job:
    """What came of the steps."""

    code: int = 0
    said: str = ""
    summary: str = ""
    outputs: dict[str, str] = field(default_factory=dict)
    uploaded: list[str] = field(default_factory=list)


class Server:
    """A folder with a program on the PATH."""

    def __init__(self, program: Path, workspace: Path):
        self.workspace = workspace
        self.bin = workspace / ".bin"
        self.bin.mkdir(parents=True)
        (self.bin / "scanbench").symlink_to(program.resolve())
        self.path = f"{self.bin}:{os.environ['PATH']}"

    def bash(self, script: str, variables: dict[str, str]) -> subprocess.CompletedProcess[str]:
        kept = {it: os.environ[it] for it in ("HOME", "LANG", "CARGO_HOME", "RUSTUP_HOME", "CARGO_TARGET_DIR") if it in os.environ}
        environment = kept | {"PATH": self.path} | variables
        return subprocess.run(
            [*BASH, script], cwd=self.workspace, env=environment, capture_output=True, text=True, check=False
        )

    def action(self, **given: str) -> Job:
        """The steps of action.yml, with these inputs."""
        action = yaml.safe_load((ROOT / "action.yml").read_text())
        names = {name.replace("-", "_"): name for name in action["inputs"]}
        assert set(given) <= set(names), given
        inputs = {name: spec.get("default") for name, spec in action["inputs"].items()}
        inputs |= {names[name]: value for name, value in given.items()}
        assert None not in inputs.values(), f"required: {inputs}"
        files = {name: self.workspace / f".{name.lower()}" for name in ("GITHUB_STEP_SUMMARY", "GITHUB_PATH")}
        for file in files.values():
            file.write_text("")
        job, of_steps = Job(), {}
        for step in action["runs"]["steps"]:
            if job.code and step.get("if") != "always()":
                continue
            values = {f"inputs.{name}": value for name, value in inputs.items()}
            if "uses" in step:
                if step["uses"].startswith("actions/upload-artifact@"):
                    job.uploaded = expanded(step["with"]["path"], values).splitlines()
                continue
            assert "${{" not in step["run"], "what users write belongs into the environment"
            output = self.workspace / ".github_output"
            output.write_text("")
            variables = {name: expanded(value, values) for name, value in step.get("env", {}).items()}
            variables |= {name: str(file) for name, file in files.items()}
            variables |= {
                "GITHUB_ACTIONS": "true",
                "GITHUB_ACTION_PATH": str(ROOT),
                "GITHUB_WORKSPACE": str(self.workspace),
                "GITHUB_OUTPUT": str(output),
            }
            ended = self.bash(step["run"], variables)
            job.code, job.said = ended.returncode, job.said + ended.stdout + ended.stderr
            for line in output.read_text().splitlines():
                name, value = line.split("=", 1)
                of_steps[f"steps.{step['id']}.outputs.{name}"] = value
        job.summary = files["GITHUB_STEP_SUMMARY"].read_text()
        job.outputs = {name: expanded(it["value"], of_steps, "") for name, it in action["outputs"].items()}
        return job


def expanded(text: str, values: dict[str, str], absent: str | None = None) -> str:
    def value(found: re.Match[str]) -> str:
        return values[found[1]] if absent is None else values.get(found[1], absent)

    return re.sub(r"\$\{\{ *([^} ]+) *\}\}", value, text)


def check_verdict(job: Job, workspace: Path, code: int, headline: str) -> None:
    """Whatever it comes to, the summary says it, and page, recording and verdict are uploaded."""
    assert job.code == code, f"exit code {job.code} instead of {code}\n{job.said}"
    assert re.fullmatch(headline, job.outputs["headline"]), job.outputs
    assert job.outputs["exit-code"] == str(code), job.outputs
    assert (workspace / job.outputs["page"]).is_file(), job.outputs
    assert job.summary.startswith(f"## scanbench\n\n**{job.outputs['headline']}**\n"), job.summary
    [folder] = job.uploaded
    for name in ("run/report.html", "run/run.rrd", "verdict/gate.json", "verdict/junit.xml", "gate.txt"):
        assert (workspace / folder / name).is_file(), f"{name} is not uploaded"
    check_services(workspace / folder / "verdict")


def check_services(directory: Path) -> None:
    """The files of a verdict as others read them: JUnit, github-action-benchmark, Bencher."""
    verdict, entries, benchmarks = (
        json.loads((directory / f"{it}.json").read_text()) for it in ("gate", "custom-smaller-is-better", "bencher")
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
    same = server.action(run=SCANS, baseline="first")
    check_verdict(same, server.workspace, 0, "PASSED")
    worse = server.action(run=f"{SCANS} -P pca.cluster.min_points=200", baseline="first", output="out/worse")
    check_verdict(worse, server.workspace, 100, "FAILED: worse")
    changed = {"run": f"{SCANS} -P pca.cluster.min_points=16", "baseline": "first"}
    check_verdict(server.action(**changed), server.workspace, 101, "FAILED: results changed")
    allowed = r"PASSED, results changed on \d+ scans? \(allowed\)"
    check_verdict(server.action(**changed, allow_drift="true"), server.workspace, 0, allowed)
    (server.workspace / "warn.toml").write_text(
        'drift = "warn"\n[[quality]]\nmetrics = ["recall"]\nslices = ["all"]\nabsolute = 0.1\nrelative = 0.0\n'
    )
    check_verdict(server.action(**changed, tolerances="warn.toml"), server.workspace, 0, allowed)
    check_verdict(
        server.action(**changed, tolerances="warn.toml", allow_drift="false"), server.workspace, 101, ".* changed"
    )
    # A run that fails is not gated, and what looks like a command is a word.
    failed = server.action(run="no-such-street '$(touch owned)' $(touch owned)", baseline="first")
    assert not (server.workspace / "owned").exists()
    assert failed.code == 2 and "headline" in failed.outputs and not failed.outputs["headline"], failed
    assert failed.uploaded, "what there is of it is uploaded"
    # No other run in its place: a quote that is not closed ends it.
    torn = server.action(run=f"{SCANS} -P pca.name='a", baseline="first", output="out/torn")
    assert torn.code == 1 and "quote" in torn.said and not (server.workspace / "out/torn").exists(), torn


def check_install(server: Server) -> None:
    """By a wheel, or from source; both are only noted, by programs that stand in for pip and cargo."""
    script = str(ROOT / ".github/action/gate.sh")
    stand_ins = server.workspace / ".stand-ins"
    stand_ins.mkdir()
    noted = stand_ins / "noted"
    for name in ("python3", "cargo"):
        program = f'#!/bin/sh\necho "{name} $* in $PWD" >> {noted}\n'
        if name == "cargo":
            program += f'mkdir -p "$CARGO_TARGET_DIR/release"\ncp {server.bin}/scanbench "$CARGO_TARGET_DIR/release/"\n'
        (stand_ins / name).write_text(program)
        (stand_ins / name).chmod(0o755)
    added = server.workspace / ".added"
    target = str(server.workspace / ".target")
    # A program on the PATH, which may be of another version, does not take the place of the source.
    variables = {"PATH": f"{stand_ins}:{server.bin}:/usr/bin:/bin", "CARGO_TARGET_DIR": target, "GITHUB_PATH": str(added)}
    ended = server.bash(f"{script} install", variables)
    assert ended.returncode == 0 and ended.stdout.startswith("scanbench "), ended
    assert noted.read_text() == f"cargo build --release --locked in {ROOT}\n"
    assert added.read_text() == f"{target}/release\n"
    noted.write_text("")
    ended = server.bash(f"{script} install", variables | {"WHEEL": "a wheel.whl"})
    assert ended.returncode == 0, ended
    assert noted.read_text() == (
        f"python3 -m pip install --quiet --disable-pip-version-check a wheel.whl in {server.workspace}\n"
    )
    # A name alone would be looked up on a package index, where anybody may have taken it.
    noted.write_text("")
    ended = server.bash(f"{script} install", variables | {"WHEEL": "scanbench"})
    assert ended.returncode == 2 and "not pinned" in ended.stderr, ended
    assert not noted.read_text(), noted.read_text()
    assert server.bash(f"{script} instal", {}).returncode == 2
    assert "the folder of the baseline" in server.bash(f"{script} gate", {}).stderr


def check_archive(server: Server) -> None:
    """The program of a release, by its checksum alone; from source where it cannot be had."""
    stand_ins = server.workspace / ".archive"
    (stand_ins / "scanbench-1").mkdir(parents=True)
    added, target = server.workspace / ".added-by-archive", server.workspace / ".target"
    programs = {
        "scanbench-1/scanbench": "echo scanbench of the release",
        "curl": f'for it; do :; done\ncp "{stand_ins}/$(basename "$it")" "${{@:$#-1:1}}"\n',
        "cargo": f'mkdir -p {target}/release\nprintf "#!/bin/sh\\necho built\\n" > {target}/release/scanbench\n'
        f"chmod +x {target}/release/scanbench\n",
    }
    for name, program in programs.items():
        (stand_ins / name).write_text(f"#!/bin/bash\n{program}")
        (stand_ins / name).chmod(0o755)
    archive = stand_ins / "a release.tar.gz"
    subprocess.run(["tar", "-czf", archive, "-C", stand_ins, "scanbench-1"], check=True)
    sum_of_it = hashlib.sha256(archive.read_bytes()).hexdigest()
    other = sum_of_it[::-1]
    for from_where, code, said in (
        (f".archive/a release.tar.gz#sha256={sum_of_it}", 0, "scanbench of the release\n"),
        (f"https://example.org/a release.tar.gz#sha256={sum_of_it}", 0, "scanbench of the release\n"),
        (f"https://example.org/none.tar.gz#sha256={sum_of_it}", 0, "built\n"),
        (f".archive/none.tar.gz#sha256={sum_of_it}", 0, "built\n"),
        (f".archive/a release.tar.gz#sha256={other}", 2, ""),
        (f"http://example.org/a release.tar.gz#sha256={sum_of_it}", 2, ""),
        (".archive/a release.tar.gz", 2, ""),
    ):
        variables = {"PATH": f"{stand_ins}:/usr/bin:/bin", "CARGO_TARGET_DIR": str(target), "GITHUB_PATH": str(added)}
        variables |= {"RUNNER_TEMP": str(server.workspace / ".temporary"), "ARCHIVE": from_where}
        added.write_text("")
        ended = server.bash(f"{ROOT}/.github/action/gate.sh install", variables)
        assert (ended.returncode, ended.stdout) == (code, said), (from_where, ended)
        assert (added.read_text() != "") == (code == 0), (from_where, added.read_text())
        shutil.rmtree(server.workspace / ".temporary", ignore_errors=True)


def check_gitlab(server: Server) -> None:
    job = yaml.safe_load((ROOT / ".gitlab/gate.yml").read_text())["scanbench"]
    variables = job["variables"] | {"RUN": SCANS.replace("'", ""), "BASELINE": "first"}
    [install, *script] = job["script"]
    assert "pip install" in install
    ended = server.bash(install, variables)
    assert ended.returncode and "the path or address of a wheel" in ended.stderr, ended
    ended = server.bash("\n".join(script), variables)
    assert ended.returncode == 0 and "\nPASSED\n" in f"\n{ended.stdout}", ended
    paths = [*job["artifacts"]["paths"], job["artifacts"]["reports"]["junit"]]
    assert all((server.workspace / it).exists() for it in paths), paths


def check_written_workflow(server: Server) -> None:
    manifest = server.workspace / "first/manifest.json"
    # Whoever changes the program runs this before there is a commit of it.
    manifest.write_text(manifest.read_text().replace('"dirty": true', '"dirty": false'))
    ended = server.bash("scanbench baseline init first -o ci", {})
    assert ended.returncode == 0, ended
    workflow = yaml.safe_load((server.workspace / "ci/scanbench.yml").read_text())
    steps = workflow["jobs"]["gate"]["steps"]
    [install] = [it["run"] for it in steps if "pip install" in it.get("run", "")]
    ended = server.bash(install, {"WHEEL": ""})
    assert ended.returncode and "SCANBENCH_WHEEL" in ended.stderr, ended
    scripts = [it["run"] for it in steps if "run" in it and "pip install" not in it["run"]]
    assert len(scripts) == 2, scripts
    ended = server.bash("\n".join(scripts), {})
    assert ended.returncode == 0 and "\nPASSED\n" in f"\n{ended.stdout}", ended
    [upload] = [it for it in steps if it.get("uses", "").startswith("actions/upload-artifact@")]
    paths = upload["with"]["path"].splitlines()
    assert all((server.workspace / it).exists() for it in paths), paths


def main() -> None:
    program, workspace = map(Path, sys.argv[1:])
    workspace.mkdir(parents=True)
    server = Server(program, workspace.resolve())
    ended = server.bash(f"scanbench run {SCANS} -o first", {})
    assert ended.returncode == 0, ended
    checks = [check_action, check_install, check_archive, check_gitlab, check_written_workflow]
    for check in checks:
        check(server)
        shutil.rmtree(server.workspace / "runs", ignore_errors=True)
        print(f"{check.__name__.removeprefix('check_').replace('_', ' ')}: as it should be")


main()
