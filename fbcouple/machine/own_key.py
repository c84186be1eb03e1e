"""A secret of this user, by which checkpoints that he wrote are told from those of anybody else.

A checkpoint holds a restart file of LIGGGHTS, which nothing but LIGGGHTS reads and which it reads without a check.
"""

from __future__ import annotations

import hmac
import os
import secrets
import stat
from pathlib import Path

from fbcouple.paths import cache_folder, find_user_folder

_NAME = "checkpoint-key"
_BYTES = 32


def key_file() -> Path:
    """Where the key is: among the user's own states (XDG), without a home folder in the cache."""
    return (find_user_folder("XDG_STATE_HOME", "~/.local/state") or cache_folder()) / _NAME


def make_key() -> None:
    """Make the key if there is none; where it cannot be written, as on many compute nodes, there is none."""
    path = key_file()
    if path.exists():
        return
    unfinished = path.with_name(f"{_NAME}.{secrets.token_hex(8)}")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        number = os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            os.write(number, secrets.token_bytes(_BYTES))
            os.fsync(number)
        finally:
            os.close(number)
        try:
            os.link(unfinished, path)  # never over one that another process has made meanwhile
        finally:
            unfinished.unlink()
    except OSError:
        return


def sign(text: str) -> str:
    """The HMAC of `text` under the key, in hexadecimal; "" where there is no key."""
    key = _read_key()
    return hmac.new(key, text.encode(), "sha256").hexdigest() if key else ""


def is_own(text: str, signature: object) -> bool:
    """Was `signature` made of `text` under this user's key?"""
    expected = sign(text)
    return bool(expected) and isinstance(signature, str) and hmac.compare_digest(expected, signature)


def _read_key() -> bytes:
    """The key, or b"" where there is none that is this user's alone."""
    try:
        number = os.open(key_file(), os.O_RDONLY | os.O_NOFOLLOW)
    except OSError:
        return b""
    with open(number, "rb") as file:
        about = os.fstat(number)
        private = stat.S_ISREG(about.st_mode) and about.st_uid == os.geteuid() and not about.st_mode & 0o077
        key = file.read(_BYTES + 1) if private else b""
    return key if len(key) == _BYTES else b""
