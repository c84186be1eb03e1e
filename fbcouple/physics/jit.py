"""How the loops over particles and cells are compiled: cached on disk, SIMD allowed, no check of each division.

A loop takes another one, a law or a scheme, by the address of what the compiler made of it (`find_address`): Numba's
own way to hand a function over asks Python for that address in every call, which costs as much as 2000 particles.
"""

from __future__ import annotations

from typing import Any

from numba import extending, f8, types
from numba.core import cgutils

from fbcouple.physics.compiler import njit

compiled = njit(cache=True, fastmath=True, error_model="numpy")
inlined = njit(inline="always", fastmath=True, error_model="numpy")
compiled_in: Any = extending.intrinsic

VECTOR = types.Array(f8, 1, "C")
LAW = types.void(VECTOR, VECTOR, VECTOR, f8, f8, VECTOR)
"""Drag law: voidage, slip, diameter (n,), gas density and viscosity, beta (n,) to fill."""
SCHEME = types.void(VECTOR, VECTOR, f8)
"""Drag over a step: beta (n,) to change, masses (n,), step."""
NUSSELT = types.void(VECTOR, VECTOR, f8, VECTOR)
"""Heat transfer law: voidage, Reynolds number (n,), Prandtl number, Nusselt number (n,) to fill."""


def compile_as(signature, cache: bool = True):
    """Compile for one signature, so that the function can be handed to another compiled one."""
    return njit(signature, cache=cache, fastmath=True, error_model="numpy")


def find_address(function: Any) -> int:
    """Where the machine code of a function of `compile_as` is; it stays there as long as the function is kept."""
    (result,) = function.overloads.values()
    return result.library.get_pointer_to_function(result.fndesc.llvm_func_name)


def _call(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """Code for a call of the function of `signature` at the address args[0] with the other arguments."""
    convention = context.call_conv
    kind = convention.get_function_type(types.none, signature.args)
    pointer = builder.inttoptr(args[0], kind.as_pointer())
    status, _ = convention.call_function(builder, pointer, types.none, signature.args, args[1:])
    with cgutils.if_unlikely(builder, status.is_error):
        convention.return_status_propagate(builder, status)
    return context.get_dummy_value()


@compiled_in
def call_law(typingctx: Any, law: Any, voidage: Any, slip: Any, diameter: Any, rho: Any, mu: Any, beta: Any) -> Any:
    """Call the drag law at the address `law`, see LAW."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _call(context, builder, LAW, args)

    return types.void(types.uintp, *LAW.args), generate


@compiled_in
def call_scheme(typingctx: Any, scheme: Any, beta: Any, masses: Any, dt: Any) -> Any:
    """Call the scheme at the address `scheme`, see SCHEME."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _call(context, builder, SCHEME, args)

    return types.void(types.uintp, *SCHEME.args), generate


@compiled_in
def call_nusselt(typingctx: Any, law: Any, voidage: Any, reynolds: Any, prandtl: Any, nusselt: Any) -> Any:
    """Call the heat transfer law at the address `law`, see NUSSELT."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _call(context, builder, NUSSELT, args)

    return types.void(types.uintp, *NUSSELT.args), generate
