"""Sparse matrices between cells, points and middles of faces, whose products are written in place."""

from __future__ import annotations

import numpy as np
import scipy

from fbcouple.physics.jit import compiled, inlined


class Rows:
    """A sparse matrix whose product with columns of a field is written in place."""

    def __init__(self, matrix: scipy.sparse.spmatrix) -> None:
        matrix = scipy.sparse.csr_matrix(matrix)
        matrix.sort_indices()
        self.shape = matrix.shape
        self._parts = matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64), matrix.data.astype(float)

    def multiply(self, field: np.ndarray, columns: int, result: np.ndarray) -> None:
        """Set the first `columns` of `result` (rows, >= columns) to the product with those of `field`."""
        _multiply(*self._parts, field, columns, result)

    def multiply_some(self, some: np.ndarray, field: np.ndarray, columns: int, result: np.ndarray) -> None:
        """The same for the rows `some` alone; the others stay as they are."""
        _multiply_some(*self._parts, some, field, columns, result)

    def add_back(self, some: np.ndarray, rows: np.ndarray, columns: int, field: np.ndarray) -> None:
        """Add the product of the transpose with the `rows` at `some` to the first `columns` of `field`."""
        _add_back(*self._parts, some, rows, columns, field)

    def mark_columns(self, some: np.ndarray, marks: np.ndarray) -> None:
        """Set `marks` at all columns that the rows `some` have entries in."""
        _mark_columns(self._parts[0], self._parts[1], some, marks)


@compiled
def _multiply(starts, columns_of, values, field, columns, result):
    for row in range(len(starts) - 1):
        _multiply_row(starts, columns_of, values, row, field, columns, result)


@compiled
def _multiply_some(starts, columns_of, values, some, field, columns, result):
    for row in some:
        _multiply_row(starts, columns_of, values, row, field, columns, result)


@inlined
def _multiply_row(starts, columns_of, values, row, field, columns, result):
    """Four columns at once, which are one vector to the compiler, then those that are left."""
    fours = columns - columns % 4
    for q in range(0, fours, 4):
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        for k in range(starts[row], starts[row + 1]):
            weight, here = values[k], field[columns_of[k], q : q + 4]
            a, b, c, d = a + weight * here[0], b + weight * here[1], c + weight * here[2], d + weight * here[3]
        result[row, q], result[row, q + 1], result[row, q + 2], result[row, q + 3] = a, b, c, d
    for q in range(fours, columns):
        total = 0.0
        for k in range(starts[row], starts[row + 1]):
            total += values[k] * field[columns_of[k], q]
        result[row, q] = total


@compiled
def _add_back(starts, columns_of, values, some, rows, columns, field):
    for row in some:
        for k in range(starts[row], starts[row + 1]):
            add_share(values[k], rows, row, columns, field, columns_of[k])


@inlined
def add_share(weight, rows, row, columns, field, cell):
    fours = columns - columns % 4
    for q in range(0, fours, 4):
        given, taken = rows[row, q : q + 4], field[cell, q : q + 4]
        a, b = taken[0] + weight * given[0], taken[1] + weight * given[1]
        c, d = taken[2] + weight * given[2], taken[3] + weight * given[3]
        taken[0], taken[1], taken[2], taken[3] = a, b, c, d
    for q in range(fours, columns):
        field[cell, q] += weight * rows[row, q]


@compiled
def _mark_columns(starts, columns_of, some, marks):
    for row in some:
        for k in range(starts[row], starts[row + 1]):
            marks[columns_of[k]] = True
