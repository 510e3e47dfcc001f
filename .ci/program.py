"""Runs programs, scanbench above all, and reads the tables that it leaves. The preamble puts this folder on PYTHONPATH."""

import csv
import json
import os
import subprocess


def run(*words, cwd=None, environment=os.environ):
    """What a command prints, which has to succeed, and within an hour."""
    words = [str(it) for it in words]
    ended = subprocess.run(words, cwd=cwd, env=environment, capture_output=True, text=True, check=False, timeout=3600)
    if ended.returncode != 0:
        raise RuntimeError(f"{words} ended with {ended.returncode}\n{ended.stdout[-2000:]}{ended.stderr[-2000:]}")
    return ended.stdout + ended.stderr


def rows(path):
    """The rows of a CSV file, by the names of its columns."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)
