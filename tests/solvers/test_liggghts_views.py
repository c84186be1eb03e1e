"""Views into LIGGGHTS' memory, which it frees and takes again as particles come, go and change ranks."""

from __future__ import annotations

import ctypes

import numpy as np

from fbcouple.solvers.liggghts import Liggghts


def test_a_place_that_held_whole_numbers_is_read_as_real_ones_afterwards():
    liggghts = Liggghts.__new__(Liggghts)  # the views alone, without a library
    liggghts._views = {}
    memory = (ctypes.c_double * 6)(*[350.0 + row for row in range(6)])
    place = ctypes.addressof(memory)
    assert liggghts._view(place, ctypes.c_int, 6).dtype == np.int32
    temperatures = liggghts._view(place, ctypes.c_double, 6)
    assert temperatures.dtype == np.float64 and temperatures.tolist() == [350.0 + row for row in range(6)]
    assert liggghts._view(place, ctypes.c_double, 6) is temperatures, "kept from step to step"
    assert liggghts._view(place, ctypes.c_double, 3).shape == (3,)
