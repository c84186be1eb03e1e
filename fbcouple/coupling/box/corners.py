"""The eight corners of a trilinear stencil: their weights, and rows of four values at them as one vector each.

Fields keep the components of a cell side by side, so that four of them are one SIMD load. Numba's own loops do not
find that; the two functions here say it to the compiler (LLVM).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba.core import types

from fbcouple.coupling.box.halo import LocalGrid
from fbcouple.physics.jit import compiled_in, inlined

_FOUR = ir.VectorType(ir.DoubleType(), 4)
_UNSET = ir.Constant(_FOUR, ir.Undefined)
_LANES = ir.Constant(ir.VectorType(ir.IntType(32), 4), [0] * 4)
_FAST = ("fast",)


class Stencil(NamedTuple):
    """Where the eight values around each particle are in a field of flat places."""

    base: np.ndarray
    """(n,): the place of the lower cell."""
    upper: np.ndarray
    """(n, 3): weight of the cell above it along each axis."""
    offsets: np.ndarray
    """(8,): steps from the lower cell to the corners."""


def corner_offsets(local: LocalGrid) -> np.ndarray:
    """Flat steps (8,) from the lower cell of a stencil to its corners 0-7 (bits: x, y, z)."""
    nx, ny, _ = local.shape
    return np.array([(c >> 2 & 1) * ny * nx + (c >> 1 & 1) * nx + (c & 1) for c in range(8)], dtype=np.uint64)


@inlined
def corner_weights(x, y, z):
    """Trilinear weights of corners 0-7 for the weights x, y, z of the upper cells."""
    low, right, back, far = (1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y
    below = 1.0 - z
    return low * below, right * below, back * below, far * below, low * z, right * z, back * z, far * z


@compiled_in
def read_four(typingctx: Any, field: Any, column: Any, first: Any, offsets: Any, weights: Any) -> Any:
    """Four numbers: sum over the corners of weight times field[place + offset, column : column + 4]."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        total = None
        for weight, address in _corners(context, builder, signature, args):
            row = builder.load(address, align=8)
            term = builder.fmul(weight, row, flags=_FAST)
            total = term if total is None else builder.fadd(total, term, flags=_FAST)
        parts = [builder.extract_element(total, ir.Constant(ir.IntType(32), k)) for k in range(4)]
        return context.make_tuple(builder, signature.return_type, parts)

    return types.UniTuple(types.float64, 4)(field, column, first, offsets, weights), generate


@compiled_in
def add_four(typingctx: Any, field: Any, column: Any, first: Any, offsets: Any, weights: Any, values: Any) -> Any:
    """Add weight times the four `values` to field[place + offset, column : column + 4] of every corner."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        four = _UNSET
        for k in range(4):
            value = builder.extract_value(args[5], k)
            four = builder.insert_element(four, value, ir.Constant(ir.IntType(32), k))
        for weight, address in _corners(context, builder, signature, args):
            row = builder.load(address, align=8)
            share = builder.fmul(weight, four, flags=_FAST)
            builder.store(builder.fadd(row, share, flags=_FAST), address, align=8)
        return context.get_dummy_value()

    return types.void(field, column, first, offsets, weights, values), generate


def _corners(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """For each corner its weight in four lanes and the address of its four values."""
    field, column, first, offsets, weights = args[:5]
    rows = context.make_array(signature.args[0])(context, builder, field)
    steps = context.make_array(signature.args[3])(context, builder, offsets)
    width = builder.extract_value(rows.shape, 1)
    for corner in range(8):
        step = builder.load(builder.gep(steps.data, [ir.Constant(ir.IntType(64), corner)]))
        flat = builder.add(builder.mul(builder.add(first, step), width), column)
        address = builder.bitcast(builder.gep(rows.data, [flat]), _FOUR.as_pointer())
        weight = builder.insert_element(_UNSET, builder.extract_value(weights, corner), ir.Constant(ir.IntType(32), 0))
        yield builder.shuffle_vector(weight, _UNSET, _LANES), address
