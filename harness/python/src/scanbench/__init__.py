"""Judges LiDAR object detectors that are Python functions, and reads what runs leave behind.

A detector is a function with `@detector` above it; `run` judges it on a data set; `Run.open` reads an earlier run.
"""

from scanbench.cloud import Cloud
from scanbench.detections import Boxes, Detections
from scanbench.detector import Configuration, Detector, detector
from scanbench.program import ScanbenchError, find_program
from scanbench.run import Run, run
from scanbench.stage import stage

__all__ = [
    "Boxes",
    "Cloud",
    "Configuration",
    "Detections",
    "Detector",
    "Run",
    "ScanbenchError",
    "detector",
    "find_program",
    "run",
    "stage",
]
