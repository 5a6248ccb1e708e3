"""Runs of a machine's file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._files import File, assigned, listed, named
from ._law import Law, own


@dataclass(frozen=True)
class Run(Mapping[str, NDArray[np.float64]]):
    """One run: its time series by the names of the CSV's columns, and its metrics.

    ``run["position_deg"]`` is an array; ``pandas.DataFrame(dict(run))`` is a table. A cell that is
    empty in the CSV is NaN.
    """

    #: Controller, motion and variant.
    label: str
    #: Metrics, with the keys of ``stiction run --json``.
    metrics: dict[str, Any] = field(repr=False)
    #: The whole record of ``stiction run --json``: parameters, events, cost, fault.
    record: dict[str, Any] = field(repr=False)
    _series: dict[str, NDArray[np.float64]] = field(repr=False)

    def __getitem__(self, column: str) -> NDArray[np.float64]:
        return self._series[column]

    def __iter__(self) -> Iterator[str]:
        return iter(self._series)

    def __len__(self) -> int:
        return len(self._series)


def run(
    file: File,
    controller: str | list[str] | None = None,
    *,
    set: Mapping[str, object] | None = None,
    target: str = "host",
    law: Law | Mapping[str, Law] | None = None,
) -> list[Run]:
    """Run the experiment of a file: each controller on each motion and variant.

    ``controller`` selects some of the file's controllers. ``set`` replaces values of the file by
    their keys, as in ``{"run.duration_s": 20}``. ``target`` is ``"host"`` (the control loop alone)
    or ``"servo"`` (with soft start and monitors, as on a device). ``law`` runs a law of your own
    beside them, as in :func:`ensemble`; it sees the joint of the file. Raises :class:`Refused` with
    the key or the name that is wrong. Ctrl-C ends it after the runs under way.
    """
    if target not in ("host", "servo"):
        raise _native.Refused(f"target {target}: must be host or servo")
    by_servo = target == "servo"
    report, columns = _native.run(
        named(file), listed(controller), assigned(set), by_servo, own(law)
    )
    return [
        Run(
            label=record["label"],
            metrics=record["metrics"],
            record=record,
            _series={name: np.frombuffer(data).copy() for name, data in series},
        )
        for record, series in zip(json.loads(report)["runs"], columns, strict=True)
    ]
