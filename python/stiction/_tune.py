"""Gains for a joint that is known within bounds."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from . import _native
from ._files import File, named, ranges


@dataclass(frozen=True)
class Tuning:
    """Outcome of a tuning."""

    #: ``tuned``, ``kept`` (the file's gains are no worse) or ``refused`` (no joint succeeds).
    outcome: str
    #: Gains that stay, by their names.
    gains: dict[str, float]
    #: Why the file's gains stay; ``None`` if others are better.
    reason: str | None
    #: The controller's object of ``stiction tune --json``: figures before and after, margins, the
    #: worst joint.
    report: dict[str, Any] = field(repr=False)
    #: Text of the file with the gains that stay; ``None`` if the tuning is refused.
    text: str | None = field(repr=False)


def tune(
    file: File,
    controller: str,
    *,
    goal: str = "balanced",
    limit: Mapping[str, float] | None = None,
    spread: Mapping[str, tuple[float, float]] | None = None,
    cases: int = 8,
    seed: int = 1_000_000,
) -> Tuning:
    """Tune a controller of a file on joints around the file's.

    ``goal`` is ``settle``, ``track`` or ``balanced``. ``limit`` is the upper limit of a metric:
    settling_s, tracking_counts, rest_counts, chatter_v_per_s or held_v. ``spread`` is the range of
    a key, instead of the file's ``[spread]``. The gains are judged on three times as many joints of
    the next seed. Takes some minutes; Ctrl-C ends it within the time of one set of joints. Raises
    :class:`Refused` with the argument or the key that is wrong.
    """
    arguments = {
        "goal": goal,
        "limits": [f"{metric}={most!r}" for metric, most in (limit or {}).items()],
        "spread": ranges(spread),
        "cases": cases,
        "seed": seed,
    }
    report, text = _native.tune(named(file), controller, arguments)
    found = json.loads(report)["controllers"][controller]
    return Tuning(
        outcome=found["outcome"],
        gains={name: gain["to"] for name, gain in found["gains"].items()},
        reason=found["reason"],
        report=found,
        text=text,
    )
