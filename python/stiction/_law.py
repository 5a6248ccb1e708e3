"""Laws of the user's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from . import _native

#: Makes the controller of a joint: a class with ``__call__``, or a function that returns one.
Law = Callable[[_native.LawJoint], Callable[[_native.LawSample], float]]


def own(law: Law | Mapping[str, Law] | None) -> list[tuple[str, str, Law]]:
    """Return name, version and callable of each law."""
    if law is None:
        return []
    if not isinstance(law, Mapping):
        law = {getattr(law, "__name__", type(law).__name__): law}
    return [(name, str(getattr(one, "version", "")), one) for name, one in law.items()]
