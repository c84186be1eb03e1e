"""Files that a case names: plain files of its own folder, whoever wrote the case."""

from __future__ import annotations

import json
from pathlib import Path

from fbcouple.errors import CaseError

_LONGEST_NAME = 255
_SHOWN = 60


def find_companion(folder: Path, name: str, suffix: str | tuple[str, ...]) -> Path:
    """The file `name` beside the case, which lies in `folder`; it ends in `suffix`, or in one of several.

    A case may come from anybody: its files are plain files of its own folder, and no link leads out of it.

    Raises: CaseError (one text, without the key) if it is not.
    """
    if not is_bare(name) or not name.endswith(suffix):
        shown = json.dumps(name[:_SHOWN], ensure_ascii=not name.isprintable())
        text = f"{shown} is given, the bare name of a {_list(suffix)} file is allowed"
        raise CaseError([f"{text}; put the file beside the case file and give its name only."])
    path = folder / name
    try:
        found = path.resolve(strict=True)
    except OSError as error:
        raise CaseError([f"{name} cannot be read: {error.strerror}; put it beside the case file."]) from None
    if found.parent != folder.resolve():
        raise CaseError([f"{name} is a link that leads out of the folder of the case; put the file itself there."])
    if not found.is_file():
        raise CaseError([f"{name} is not a plain file; put a {_list(suffix)} file beside the case file."])
    return path


def _list(suffix: str | tuple[str, ...]) -> str:
    return suffix if isinstance(suffix, str) else f"{', '.join(suffix[:-1])} or {suffix[-1]}"


def is_bare(name: str) -> bool:
    """Is it the name of a file, and no path?"""
    return Path(name).name == name and "\\" not in name and name.isprintable() and len(name) <= _LONGEST_NAME
