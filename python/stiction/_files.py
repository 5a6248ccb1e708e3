"""Machine's files: a first one, and what is doubtful in one."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from pathlib import Path

from . import _native

#: A machine's file, or the name of a built-in experiment.
File = str | os.PathLike[str]


class Doubt(UserWarning):
    """A value that is allowed and doubtful, such as a friction that no joint of its size has."""


def named(file: File) -> str:
    """Return the file's name, after a warning for each doubt about it."""
    name = os.fspath(file)
    for doubt in _native.doubts(name):
        warnings.warn(doubt, Doubt, stacklevel=3)
    return name


def listed(names: str | list[str] | tuple[str, ...] | None) -> list[str]:
    """Return names as a list; one name can stand alone."""
    if names is None:
        return []
    return [names] if isinstance(names, str) else list(names)


def assigned(values: Mapping[str, object] | None) -> list[str]:
    """Return keys and values as ``key=value``, as the command line has them."""
    return [f"{key}={_typed(value)}" for key, value in (values or {}).items()]


def ranges(spread: Mapping[str, tuple[float, float]] | None) -> list[str]:
    """Return keys and ranges as ``key=LOW..HIGH``."""
    return [f"{key}={low!r}..{high!r}" for key, (low, high) in (spread or {}).items()]


def _typed(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else repr(value)


def experiments() -> dict[str, str]:
    """Return the built-in experiments: name, and where it is from."""
    return dict(_native.experiments())


def typical_joints() -> list[str]:
    """Return the names of the joints that ``draft`` and ``new`` can start with."""
    return _native.typical()


def draft(
    like: str | None = None,
    answers: Mapping[str, object] | None = None,
    *,
    title: str = "A joint of my own",
) -> str:
    """Return the text of a machine's file: the joint, controllers with gains, a step.

    ``like`` is one of :func:`typical_joints`. ``answers`` are values of the joint by their keys,
    such as ``{"load.inertia_kg_m2": 0.4, "friction.stick_nm": (4, 9)}``; a pair is a range. They
    replace those of the typical joint. Raises :class:`Refused` with the keys that are missing.
    """
    text, doubts = _native.draft("draft", like, _answers(answers, title))
    for doubt in doubts:
        warnings.warn(doubt, Doubt, stacklevel=2)
    return text


def new(
    file: File,
    like: str | None = None,
    answers: Mapping[str, object] | None = None,
    *,
    title: str | None = None,
    force: bool = False,
) -> Path:
    """Write the text of :func:`draft` to a file, and return its path.

    A file that exists is kept and raises ``FileExistsError``, unless ``force`` is set. The title is
    the name of the file, unless it is given.
    """
    path = Path(file)
    text = draft(like, answers, title=path.stem if title is None else title)
    with path.open("w" if force else "x", encoding="utf-8") as stream:
        stream.write(text)
    return path


def _answers(answers: Mapping[str, object] | None, title: str) -> list[tuple[str, str]]:
    def typed(value: object) -> str:
        if isinstance(value, (tuple, list)) and len(value) == 2:
            return f"{value[0]!r}..{value[1]!r}"
        return _typed(value)

    pairs = [(key, typed(value)) for key, value in (answers or {}).items()]
    return [("title", title), *pairs]
