"""The optimal assignment, by scipy."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment


def assign(costs: NDArray[np.float64]) -> list[tuple[int, int]]:
    """As many pairs of a row and a column as can be, then the least sum of costs, then the first rows. NaN is no pair."""
    if 0 in costs.shape:
        return []
    # One pair more outweighs all costs there can be.
    reward = 1.0 + np.nansum(costs)
    # Far less than two different costs differ.
    ties = 1e-11 * np.arange(len(costs))[:, None]
    rows, columns = linear_sum_assignment(np.where(np.isnan(costs), 0.0, costs + ties - reward))
    return [(int(row), int(column)) for row, column in zip(rows, columns) if not np.isnan(costs[row, column])]
