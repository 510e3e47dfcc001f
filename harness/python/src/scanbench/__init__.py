"""Judges LiDAR object detectors that are Python functions, and reads what runs leave behind.

A detector is a function with `@detector` above it; `run` judges it on a data set; `Run.open` reads an earlier run. `score` judges
boxes that are in memory.
"""

from scanbench.cloud import Cloud
from scanbench.detections import Boxes, Detections
from scanbench.detector import Configuration, Detector, detector
from scanbench.program import ScanbenchError, find_program
from scanbench.run import Run, run
from scanbench.score import Annotations, Score, score
from scanbench.stage import stage

__all__ = [
    "Annotations",
    "Boxes",
    "Cloud",
    "Configuration",
    "Detections",
    "Detector",
    "Run",
    "ScanbenchError",
    "Score",
    "detector",
    "find_program",
    "run",
    "score",
    "stage",
]
