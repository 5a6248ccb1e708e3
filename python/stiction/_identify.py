"""Identification of a joint from a log."""

from __future__ import annotations

import json
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from . import _native


def identify(
    time: ArrayLike,
    position: ArrayLike,
    effort: ArrayLike,
    *,
    time_unit: str = "s",
    position_unit: str = "rad",
    counts_per_turn: float | None = None,
    effort_gain: float | None = None,
    effort_delay: float | None = None,
    cut_off: float | None = None,
    model: str | None = None,
    stribeck: bool = False,
    gravity: bool = False,
) -> dict[str, Any]:
    """Identify inertia and friction from a log of motion both ways.

    ``time``, ``position`` and ``effort`` have the same length; at most a tenth of the samples can
    be NaN. ``time_unit`` is s, ms, us or ns. ``position_unit`` is rad, deg, m, mm or count; counts
    need ``counts_per_turn``. ``effort_gain`` is the torque (N m) or force (N) per unit of effort;
    without it parameters are in units of the effort. ``effort_delay`` (s) and ``cut_off`` (Hz) are
    estimated unless given. ``model`` is ``"symmetric"`` or ``"asymmetric"``, chosen from the log
    unless given. ``stribeck`` and ``gravity`` add a term each.

    Returns the object of ``stiction identify --json``: ``parameters`` with ``value`` and ``sd``,
    their ``units``, the ``verdict`` with its reasons, ``warnings``. Read the verdict before the
    numbers. Raises :class:`Refused` if the log does not identify its joint, with what to do; rows
    are counted from 1. docs/how-to/identify.md has equations and limits.
    """
    if model not in (None, "symmetric", "asymmetric"):
        raise _native.Refused(f"model {model}: must be symmetric or asymmetric")
    series = (_doubles("time", time), _doubles("position", position), _doubles("effort", effort))
    settings = {
        "time_unit": time_unit,
        "position_unit": position_unit,
        "counts_per_turn": counts_per_turn,
        "effort_gain": effort_gain,
        "effort_delay": effort_delay,
        "cut_off": cut_off,
        "asymmetric": None if model is None else model == "asymmetric",
        "stribeck": stribeck,
        "gravity": gravity,
    }
    return cast(dict[str, Any], json.loads(_native.identify(*series, settings)))


def _doubles(name: str, values: ArrayLike) -> bytes:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 1:
        raise _native.Refused(f"{name} has {array.ndim} dimensions; must have one")
    return array.tobytes()
