"""A joint that a program steps, sample by sample."""

from __future__ import annotations

from typing import NamedTuple

from . import _native
from ._files import File, named


class Sample(NamedTuple):
    """The joint at one sampling instant."""

    #: Time since the reset, s.
    time_s: float
    #: Reading of the encoder, counts. A controller has only this.
    counts: int
    #: True position of the joint, deg.
    position_deg: float
    #: True position of the load behind gear and shaft, deg.
    at_load_deg: float
    #: True velocity of the joint, deg/s.
    velocity_deg_per_s: float
    #: Whether the joint sticks.
    stuck: bool
    #: Effort that the drive held until this sample, V.
    applied_v: float


class Joint:
    """The joint of a machine's file, behind its amplifier and its encoder.

    The friction is Karnopp's: at rest the joint holds against any effort up to its stick friction;
    it is in closed form between two samples unless a data sheet describes more. The drive limits
    and rounds each effort, and delays it by the samples of ``run.delay_samples``. There are no
    monitors and no soft start here: the caller's controller acts alone.
    """

    def __init__(self, file: File) -> None:
        self._joint = _native.Joint(named(file))

    @classmethod
    def from_file(cls, file: File) -> Joint:
        """Open a machine's file, or a built-in experiment by its name.

        Raises :class:`Refused` with the key that is wrong, or ``OSError`` for a file that cannot be
        read.
        """
        return cls(file)

    @property
    def sample_time_s(self) -> float:
        """Time between two steps, s."""
        return self._joint.sample_time_s

    @property
    def count_deg(self) -> float:
        """Angle of one count of the encoder at the joint, deg."""
        return self._joint.count_deg

    @property
    def largest_effort_v(self) -> float:
        """Effort beyond which the drive limits, V."""
        return self._joint.largest_effort_v

    @property
    def nm_per_v(self) -> float | None:
        """Torque at the joint per volt of effort, N m/V; ``None`` without a data sheet."""
        return self._joint.nm_per_v

    @property
    def drawn(self) -> dict[str, float]:
        """The keys that the seed of the last reset has drawn; empty without a seed."""
        pairs = (one.split("=", 1) for one in self._joint.drawn)
        return {key: float(value) for key, value in pairs}

    def reset(self, seed: int | None = None) -> Sample:
        """Put the joint at rest at zero, and return its first sample.

        Without a seed it is the file's joint. A seed draws another one from the file's
        ``[spread]``; a file without a spread has that of ``tune``: 20 % of the inertia, 25 % of the
        friction at rest and in motion, 50 % of the viscous friction. The same seed draws the same
        joint on every machine.
        """
        return Sample._make(self._joint.reset(seed))

    def step(self, effort_v: float) -> Sample:
        """Hold an effort (V) until the next sample, and return that sample.

        An effort beyond ``largest_effort_v`` is limited; one that is not a number is zero.
        """
        return Sample._make(self._joint.step(effort_v))
