"""Motion and reactions of large systems of material points under constraints.

A `System` describes points, constraints and forces; a `Simulation` moves it, a `Dynamics` answers at one instant, an
`InverseDynamics` finds the forces of a given motion, and a `Constrainer` serves a simulation that owns its arrays and
its time loop. `find_equilibrium` and `modes` say where it rests and how it swings there. Wrong input is an `InputError`; what the numbers refuse is in a report's `outcome`, never an exception.
"""

from ._core import *  # noqa: F403
from ._core import InputError, __version__  # noqa: F401
from .description import KINDS as _KINDS
from .description import Definition, Formula, System, Table, tells_names  # noqa: F401
from . import plot  # noqa: F401
from .runs import Failed, Group, Member, Trajectory, run, run_scene  # noqa: F401

globals().update(_KINDS)
for _each in (validate, num_equations, equation_names, find_equilibrium, modes, find_buckling):  # noqa: F405
    globals()[_each.__name__] = tells_names(_each)
__all__ = sorted(name for name in globals() if name[0].isupper()) + [
    "equation_names", "find_buckling", "find_equilibrium", "modes", "num_equations", "run", "run_scene", "validate"]
