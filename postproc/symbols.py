"""The letters of figures, and what each of them is."""

from __future__ import annotations

SYMBOLS: dict[str, tuple[str, str]] = {
    r"\alpha_p": (r"\alpha_p", "solids fraction"),
    r"\varepsilon": (r"\varepsilon", "voidage"),
    r"\rho_p": (r"\rho_p", "particle density"),
    r"\mathbf{U}_p": (r"\mathbf{U}_p", "particle velocity"),
    r"\mathbf{u}_p": (r"\mathbf{u}_p", "velocity of a particle"),
    r"U_{p,z}": (r"U_{p,z}", "upward particle velocity"),
    r"q_p^2": (r"q_p^2", "mean square of the particle velocity about its time mean"),
    r"\rho\,": (r"\rho", "gas density"),
    "U_f": ("U_f", "superficial inlet velocity"),
    r"\rangle_{xz}": (r"\langle\,\rangle_{xz}", "mean over the depth"),
    r"\rangle$": (r"\langle\,\rangle", "time mean"),
    r"\rangle /": (r"\langle\,\rangle", "time mean"),
    "x/L": ("L", "box width"),
    "y/D": ("D", "box depth"),
    "z/H": ("H", "box height"),
}
"""What stands in a label -> the letter in a legend, and what it is."""


def explain(*labels: str, known: str = "") -> str:
    """The letters of `labels` in words, for the note of a figure; without those that the note `known` explains."""
    text = " ".join(labels)
    found = {letter: words for part, (letter, words) in SYMBOLS.items() if part in text}
    return "; ".join(f"${letter}$\u00a0{words}" for letter, words in found.items() if f"${letter}$ =" not in known)
