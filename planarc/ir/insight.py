"""Knowledge of a mechanism beyond its variables: given by `insight`, shown by `view`.

All is plain data over the rows of one result.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from planarc.core.data import Data

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: A number, or one number for each row of the result.
Track: TypeAlias = "float | Vector"


#: The title of the figure of what drives the mechanism.
DRIVES = "Drives"


class Series(Data):
    """A curve that is no variable of the model, by its name, over the rows."""

    name: str
    unit: str
    description: str
    values: Vector


class Peak(Data):
    """The largest value of a quantity over a run, with its sign, and its root mean square."""

    name: str
    unit: str
    value: float
    time: float  # s, where it is largest
    rms: float

    @property
    def largest(self) -> float:
        return abs(self.value)


class Mark(Data):
    """A point in the world (m), and a vector there (`u`, `v`, in the layer's unit) or none."""

    name: str
    x: Track
    y: Track
    u: Track = 0.0
    v: Track = 0.0
    on: bool = True


class Layer(Data):
    """Something that may be laid over the moving mechanism; `kind`: paths, vectors or centres."""

    id: str
    title: str
    kind: str
    unit: str
    members: tuple[Mark, ...]
    on: bool = False


class Insight(Data):
    """What is known of a run's mechanism. `facts` are labels with texts, `figures` titles with the
    names of series or variables."""

    facts: tuple[tuple[str, str], ...] = ()
    series: tuple[Series, ...] = ()
    figures: tuple[tuple[str, tuple[str, ...], bool], ...] = ()
    layers: tuple[Layer, ...] = ()
    peaks: tuple[Peak, ...] = ()
