"""A sphere against a wall, worked out: damped linear spring, exact and by the schemes of Hamidouche et al. 2019.

Figures 3 and 4 of the paper; only the collision force acts (eq. 16).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

Step = Callable[[np.ndarray, np.ndarray, float], tuple[np.ndarray, np.ndarray]]


def normal_damping(stiffness: float, mass: float, restitution: float) -> float:
    """Damping rate gamma_n [1/s] of a contact with effective mass `mass` [kg] and spring `stiffness` [N/m] (eq. 18)."""
    log_e = math.log(restitution)
    return -math.sqrt(stiffness / mass) * log_e / math.hypot(math.pi, log_e)


def contact_time(stiffness: float, mass: float, restitution: float) -> float:
    """Duration T_C [s] of a contact (eq. 19)."""
    return math.pi / math.sqrt(stiffness / mass - normal_damping(stiffness, mass, restitution) ** 2)


class Impact:
    """A sphere that meets a wall with `restitution`, in units of its mass, its spring and its speed.

    Times go in as parts of T_C; overlaps come out as parts of the largest, velocities as parts of that of the impact.
    """

    def __init__(self, restitution: float) -> None:
        self.damping = normal_damping(1.0, 1.0, restitution)
        """gamma_n over omega_0."""
        self.duration = contact_time(1.0, 1.0, restitution)
        """T_C omega_0."""
        self._swing = math.sqrt(1.0 - self.damping**2)
        self.largest = math.exp(-self.damping / self._swing * math.acos(self.damping))
        """Largest overlap times omega_0 over the speed."""

    def solve(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Overlap and velocity at `times` (eqs 43-44)."""
        t = times * self.duration
        fall, sine, cosine = np.exp(-self.damping * t), np.sin(self._swing * t), np.cos(self._swing * t)
        overlap = fall * sine / self._swing
        return overlap / self.largest, fall * (cosine - self.damping / self._swing * sine)

    def integrate(self, step: Step, per_contact: int, count: int, phases: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Overlap and velocity, (count + 1, phases) each, in steps of T_C over `per_contact`.

        phases: parts of a step between the start and the contact.
        """
        dt = self.duration / per_contact
        x, v = [-phases * dt], [np.ones_like(phases)]
        for _ in range(count):
            following = step(x[-1], v[-1], dt)
            x.append(following[0])
            v.append(following[1])
        return np.array(x) / self.largest, np.array(v)

    def euler(self, x: np.ndarray, v: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Explicit Euler."""
        return x + dt * v, v + dt * self._accelerate(x, v)

    def rk2(self, x: np.ndarray, v: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Midpoint rule of the paper (eqs 40-41)."""
        middle = x + dt / 2 * v, v + dt / 2 * self._accelerate(x, v)
        return x + dt * middle[1], v + dt * self._accelerate(*middle)

    def _accelerate(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Unit mass and spring, with force only while they touch (eq. 16)."""
        return np.where(x > 0.0, -(x + 2.0 * self.damping * v), 0.0)
