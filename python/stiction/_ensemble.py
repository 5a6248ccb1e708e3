"""Controllers on many joints."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from . import _native
from ._files import File, listed, named, ranges
from ._law import Law, own


@dataclass(frozen=True)
class Ensemble:
    """Rows of an ensemble, one for each joint and controller.

    ``pandas.DataFrame(ensemble.rows)`` is a table with the columns of ``stiction ensemble --csv``;
    the documentation of the command has their meaning.
    """

    #: A row for each joint and controller.
    rows: list[dict[str, Any]] = field(repr=False)
    #: What was run: seed, number of joints, families, version. It belongs to the rows.
    header: dict[str, Any]
    #: Rates of success with their intervals, and quantiles, as ``stiction ensemble --json``.
    summary: dict[str, Any] = field(repr=False)


def ensemble(
    plant: File | list[str] = "rigid",
    *,
    cases: int = 100,
    seed: int = 1,
    controller: str | list[str] | None = None,
    spread: Mapping[str, tuple[float, float]] | None = None,
    hard: bool = False,
    rate: float | None = None,
    condition: str = "nominal",
    bridge: str = "ideal",
    motion: str = "profiled",
    moves: int = 0,
    law: Law | Mapping[str, Law] | None = None,
) -> Ensemble:
    """Run untuned controllers on drawn joints, with soft start and all monitors.

    ``plant`` is a family such as ``"rigid"`` or ``"flexible-load"``, a list of families, or a
    machine's own file (``.toml``), whose controllers then run on joints around the file's. Laws are
    named by ``controller``; all of them run without it. ``spread`` belongs to a file: the range of
    a key, instead of the file's ``[spread]``. ``hard``, ``condition``, ``bridge``, ``motion`` and
    ``moves`` belong to families; docs/how-to/ensembles.md explains them. ``rate`` is in Hz, 1000
    for families unless given.

    ``law`` runs a law of your own beside them: a callable that takes a :class:`LawJoint` and
    returns a controller, which takes a :class:`LawSample` in each tick and returns the effort. Its
    name is the callable's, or the key of a mapping; its attribute ``version`` is in the header. It
    has the servo, the soft start and the monitors of every law. Its attribute
    ``following_error``, if it has one, takes the joint and returns the following error that is a
    fault, rad: for a law that follows a path of its own. An exception of the law ends the
    ensemble.

    The rows depend on the seed and the arguments alone, on any number of cores. Raises
    :class:`Refused` with the argument that is wrong. Ctrl-C ends it within the time of a joint.
    """
    names = [os.fspath(plant)] if isinstance(plant, (str, os.PathLike)) else list(plant)
    files = [name for name in names if name.endswith(".toml")]
    if files:
        foreign = {
            "hard": hard,
            "condition": condition != "nominal",
            "bridge": bridge != "ideal",
            "motion": motion != "profiled",
            "moves": moves > 0,
            "another plant": len(names) > 1,
        }
        for argument, given in foreign.items():
            if given:
                raise _native.Refused(f"{argument} does not go with plant={files[0]!r}")
        name = named(files[0])
        text = _native.ensemble_of_file(
            name, (cases, seed), listed(controller), ranges(spread), rate, own(law)
        )
    else:
        if spread:
            raise _native.Refused("spread needs a machine's own file: plant='joint.toml'")
        text = _native.ensemble(
            {
                "families": names,
                "cases": cases,
                "seed": seed,
                "controllers": listed(controller),
                "hard": hard,
                "rate": 1000.0 if rate is None else rate,
                "condition": condition,
                "bridge": bridge,
                "motion": motion,
                "moves": moves,
            },
            own(law),
        )
    found = json.loads(text)
    return Ensemble(rows=found["rows"], header=found["header"], summary=found["summary"])
