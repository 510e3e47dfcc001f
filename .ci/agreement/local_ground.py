"""How high objects reach above the ground around them."""

from labelled_scan import LabelledScan


def tall_objects(scan: LabelledScan) -> frozenset[int]:
    """The annotations that reach more than 3.10 m above the ground."""
    return frozenset()
