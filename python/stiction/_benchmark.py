"""The ranking of a file's controllers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, cast

from . import _native
from ._files import File, assigned, named
from ._law import Law, own


def benchmark(
    file: File,
    weights: Mapping[str, float] | None = None,
    *,
    law: Law | Mapping[str, Law] | None = None,
) -> list[dict[str, Any]]:
    """Run every controller of a file on its motions, and return a row for each, the best first.

    A row has the keys of ``stiction benchmark --json``; ``pandas.DataFrame`` makes a table of the
    rows. ``weights`` are those of the columns rest, overshoot, settling, tracking, chatter, hunting
    and sticks in the mean place; 1 each unless given. A controller that is unstable, never moves
    the joint or never settles has the reason in ``disqualified`` and no place. ``law`` ranks a law
    of your own beside them, as in :func:`ensemble`; it sees the joint of the file.
    """
    text = _native.benchmark(named(file), assigned(weights), own(law))
    return cast(list[dict[str, Any]], json.loads(text))
