"""Reads the files of a gate as others read them: verdict_formats.py DIR"""

import json
import sys
from pathlib import Path

from junitparser import Failure, JUnitXml, Skipped

directory = Path(sys.argv[1])
verdict = json.loads((directory / "gate.json").read_text())
junit = JUnitXml.fromfile(str(directory / "junit.xml"))
cases = [case for suite in junit for case in suite]
assert junit.tests == len(cases) > 0, junit.tests
failed = [it for it in cases if any(isinstance(result, Failure) for result in it.result)]
skipped = [it for it in cases if any(isinstance(result, Skipped) for result in it.result)]
findings = [it["finding"] for it in verdict["metrics"] + verdict["speeds"]]
n_drift = len(verdict["drift"])
n_allowed = n_drift if verdict["drift_rule"] == "warn" else 0
n_uncompared = 1 if verdict["speed_not_compared"] else 0
assert len(failed) == findings.count("regression") + n_drift - n_allowed == junit.failures, len(failed)
assert len(skipped) == findings.count("inconclusive") + n_allowed + n_uncompared == junit.skipped, len(skipped)
assert (verdict["conclusion"] == "allowed-drift") <= (n_allowed > 0)
assert all(case.name and case.classname for case in cases)

# github-action-benchmark: https://github.com/benchmark-action/github-action-benchmark, "custom" tools.
entries = json.loads((directory / "custom-smaller-is-better.json").read_text())
assert entries and all(isinstance(it["name"], str) and isinstance(it["unit"], str) for it in entries)
assert all(isinstance(it["value"], (int, float)) and it["value"] >= 0 for it in entries)
assert len({it["name"] for it in entries}) == len(entries)
assert all(set(it) <= {"name", "unit", "value", "range", "extra"} for it in entries)

# Bencher metric format: https://bencher.dev/docs/reference/bencher-metric-format/
for name, measures in json.loads((directory / "bencher.json").read_text()).items():
    assert name and measures
    for measure in measures.values():
        assert set(measure) <= {"value", "lower_value", "upper_value"}
        low, high = measure.get("lower_value", measure["value"]), measure.get("upper_value", measure["value"])
        assert low <= measure["value"] <= high, (name, measure)
print(f"{len(cases)} test cases, {len(failed)} failed, {len(skipped)} inconclusive or allowed")
