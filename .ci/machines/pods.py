"""Jobs of Kubernetes, run as a cluster would run their containers: the same words, the same variables, a claim that is a folder."""

import json
import os
import re
import subprocess
from pathlib import Path


def expanded(word, variables):
    """A word of `command` or `args`: `$(NAME)` is a variable, an unknown one stays; `$$` is `$`."""

    def value(found):
        return "$" if found[0] == "$$" else variables.get(found[1], found[0])

    return re.sub(r"\$\$|\$\(([^)]*)\)", value, word)


def run_pod(container, index, claim, path):
    """Exit code and output of one container. `path` has the programs of the image."""
    own = {} if index is None else {"JOB_COMPLETION_INDEX": str(index)}
    own |= {it["name"]: it["value"] for it in container.get("env", [])}
    assert container["workingDir"] == container["volumeMounts"][0]["mountPath"], container
    words = [expanded(it, own) for it in container["command"] + container["args"]]
    # Nothing of our own environment: a container has none of it.
    ended = subprocess.run(
        words, cwd=claim, env=own | {"PATH": path}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    return ended.returncode, ended.stdout


def run_job(job, claim, path):
    """Runs all pods of a job; returns the types of its conditions that are true, and what the pods printed."""
    spec = job["spec"]
    [container] = spec["template"]["spec"]["containers"]
    is_indexed = spec.get("completionMode") == "Indexed"
    indices = range(spec["completions"]) if is_indexed else [None]
    n_again = spec["backoffLimitPerIndex"] if is_indexed else spec["backoffLimit"]
    printed, n_failed = [], 0
    for index in indices:
        for _ in range(1 + n_again):
            code, output = run_pod(container, index, claim, path)
            printed.append(f"{job['metadata']['name']} {index}: {code}\n{output}")
            if code == 0:
                break
        else:
            n_failed += 1
    conditions = ["FailureTarget", "Failed"] if n_failed else ["SuccessCriteriaMet", "Complete"]
    return conditions, printed


def kubectl(arguments):
    """The little of `kubectl` that submit.sh uses. Its state is in the folder KUBECTL_STATE, the claim is the folder CLAIM."""
    import yaml

    state = Path(os.environ["KUBECTL_STATE"])
    if arguments[0] == "apply" and arguments[1] == "-f":
        job = yaml.safe_load(Path(arguments[2]).read_text(encoding="utf-8"))
        job_file = state / job["metadata"]["name"]
        if job_file.exists():
            print(f"job.batch/{job_file.name} unchanged")
            return 0
        conditions, printed = run_job(job, os.environ["CLAIM"], os.environ["IMAGE_PATH"])
        job_file.write_text(json.dumps(conditions), encoding="utf-8")
        (state / f"{job_file.name}.log").write_text("".join(printed), encoding="utf-8")
        print(f"job.batch/{job_file.name} created")
        return 0
    if arguments[0] == "get" and arguments[2] == "-o":
        job_file = state / arguments[1].removeprefix("job/")
        if not job_file.exists():
            return 1
        assert arguments[3] == 'jsonpath={.status.conditions[?(@.status=="True")].type}', arguments
        print(" ".join(json.loads(job_file.read_text(encoding="utf-8"))), end="")
        return 0
    raise SystemExit(f"kubectl {arguments}")


if __name__ == "__main__":
    import sys

    sys.exit(kubectl(sys.argv[1:]))
