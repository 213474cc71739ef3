"""Loads on a structure: forces and moments with a phase, pressure, base motion, weight. Every method returns a changed copy."""

import copy

import numpy as np
from numpy.typing import ArrayLike

from . import loads
from .sparse_rows import is_petsc

PRELOAD = None  # in place of the name of a load pattern


class Loaded:
    """The part of `Structure` that puts loads on it."""

    inertia = {}  # name of a pattern, or PRELOAD, to the acceleration (3,) of all masses in it

    def with_force(self, where: str | ArrayLike, vector: ArrayLike, *, name: str = "force", phase: float = 0.0) -> "Loaded":
        """With more excitation: `vector` (3,) [N] in all, in equal shares on the nodes of a set (as in `clamped`).

        A share on a clamped dof goes into the support.

        Parameters
        ----------
        name : str
            The load pattern it belongs to. What has another course needs another pattern.
        phase : float [rad]
            So much later than cos(omega t). With a phase, or a complex vector for Re(vector exp(i omega t)), there are two patterns:
            `name`, the cosine, and `name` + "_sin", a quarter period later. `Model.excitation` has both for the case file.
        """
        vector = loads.numbers_of(vector, "force", (3,), "N")
        rows = self._loaded_rows(where, "force")
        said = f"no node of {said_of(where)} can take the force {vector.tolist()}"
        return self._with_shares(self.dofs_of(rows), np.tile(vector / len(rows), (len(rows), 1)), name, phase, said, rows=rows)

    def with_moment(self, where: str | ArrayLike, moment: ArrayLike, *, name: str = "force", phase: float = 0.0) -> "Loaded":
        """With more excitation: `moment` (3,) [N m], as forces on the nodes of a set that together are no force.

        They go round the middle of the nodes and grow with the distance from it. `name`, `phase` as in `with_force`.
        """
        moment = loads.numbers_of(moment, "moment", (3,), "N m")
        rows = self._loaded_rows(where, "moment")
        shares = loads.of_moment(self.nodes[rows], moment, said_of(where))
        said = f"no node of {said_of(where)} can take the moment {moment.tolist()}"
        return self._with_shares(self.dofs_of(rows), shares, name, phase, said, rows=rows)

    def with_pressure(self, where: str | ArrayLike, pressure: ArrayLike, *, fourier: ArrayLike | None = None,
                      name: str = "pressure") -> "Loaded":
        """With more excitation: a pressure onto a surface, against its outward normal.

        Parameters
        ----------
        where : str
            Name of a surface with faces. Nodes come in the order of `surface(where).labels`.
        pressure : float, (m,) or (m, 2H+1) array [Pa]
            Everywhere, or at each node; complex for Re(pressure exp(i omega t)). Or at each node a series [p0, a1, b1, ...], which makes
            a pattern of every coefficient: `name` + "_a1", "_b1" and so on.
        fourier : list, optional
            Series [f0, a1, b1, ...] that multiplies a real pressure of one number, or one per node; default [0, 1].

        A constant part, half the first coefficient of a series, goes into the preload.
        """
        surface = self.surface(where)
        area, nodes, said = surface.area_vectors(), len(surface.points), f"no node of surface {where!r} can take the pressure"
        if np.ndim(pressure) == 2 or fourier is not None:
            each = loads.pressure_series(pressure, nodes, fourier)
            result = self._with_shares(surface.dofs, -each[:, [0]] / 2 * area, PRELOAD, 0.0, said)
            if fourier is not None:
                moving = [0.0, *map(float, fourier[1:])]
                shares = -np.broadcast_to(pressure, (nodes,))[:, None] * area
                return result._with_shares(surface.dofs, shares, name, 0.0, said, moving) if any(moving) else result
            for place in range(1, each.shape[1]):
                if np.any(each[:, place]):
                    result = result._with_shares(surface.dofs, -each[:, [place]] * area, loads.series_name(name, place), 0.0, said,
                                                 [0.0] * place + [1.0])
            return result
        pressure = loads.numbers_of(np.broadcast_to(pressure, (nodes,)) if np.ndim(pressure) == 0 else pressure, "pressure", (nodes,), "Pa")
        return self._with_shares(surface.dofs, -pressure[:, None] * area, name, 0.0, said)

    def with_base_acceleration(self, direction: ArrayLike, *, name: str = "base") -> "Loaded":
        """With more excitation: all that holds the structure, and the ground of its joints, accelerates along `direction` (3,).

        Displacements are then those relative to the base. The pattern is -M r for 1 m/s^2, r the motion with the base, so that the series
        of the case file is the acceleration [m/s^2]. To be called before `clamped`, which names the nodes of the base: K r must be 0.
        """
        direction = loads.real_vector(direction, "direction", "-")
        if not np.any(direction):
            raise ValueError("direction must not be zero")
        r = loads.translation(self, direction / np.linalg.norm(direction))
        loads.need_free(self, r, "a base acceleration")
        return self._with_values({name: (-loads.times(self.M, r), loads.FORTH)})._with_inertia(name, direction / np.linalg.norm(direction))

    def with_gravity(self, acceleration: ArrayLike) -> "Loaded":
        """With more preload: the weight of all masses under `acceleration` (3,) [m/s^2], such as [0, 0, -9.81]."""
        acceleration = loads.real_vector(acceleration, "acceleration", "m/s^2")
        result = self._with_values({PRELOAD: (loads.times(self.M, loads.translation(self, acceleration)), None)})
        return result._with_inertia(PRELOAD, acceleration)

    def _with_inertia(self, name, acceleration):
        result = copy.copy(self)
        result.inertia = self.inertia | {name: self.inertia.get(name, np.zeros(3)) + acceleration}
        return result

    def with_preload(self, where: str | ArrayLike, vector: ArrayLike) -> "Loaded":
        """With more static load P: `vector` (3,) [N] in all, in equal shares as in `with_force`."""
        vector = loads.real_vector(vector, "preload", "N")
        rows = self._loaded_rows(where, "preload")
        said = f"no node of {said_of(where)} can take the preload {vector.tolist()}"
        return self._with_shares(self.dofs_of(rows), np.tile(vector / len(rows), (len(rows), 1)), PRELOAD, 0.0, said, rows=rows)

    def with_step(self, step: str | int) -> "Loaded":
        """With more static load P: what a static step of the imported deck is loaded with, of those in `steps`."""
        if step not in self.steps:
            raise ValueError(f"there is no step {step!r} with loads in the deck, beside the one that writes the matrices; there are: "
                             f"{', '.join(map(str, self.steps)) or 'none'}")
        return self._with_values({PRELOAD: (self.steps[step], None)})

    def _loaded_rows(self, where, what):
        tied = isinstance(where, str) and where in self.tied_sets and where not in self.node_sets
        rows = np.unique(self.tied_sets[where] if tied else self._nodes(where))
        if not rows.size:
            raise ValueError(f"no node to put the {what} on: {said_of(where)} is empty")
        return rows

    def _with_shares(self, dofs, shares, name, phase, said, course=None, rows=None):
        """Forces (k, 3) on dofs (k, 3), those of clamped dofs left out; `said` begins the message where none is left.

        With node `rows` (k,), forces on directions that follow others go through their equations.
        """
        used = (dofs >= 0) & (shares != 0)
        values = np.zeros(self.n, dtype=shares.dtype)
        np.add.at(values, dofs[used], shares[used])
        if rows is not None:
            node, axis = np.nonzero((dofs < 0) & (shares != 0))
            values += self.followers.force(rows[node], axis, shares[node, axis])
        if np.any(shares) and not values.any():
            raise ValueError(f"{said}: none has a free dof in its direction")
        if name is PRELOAD:
            return self._with_values({PRELOAD: (values, None)}) if values.any() else self
        parts = loads.with_phase(values, phase, name)
        return self._with_values({part: (load, course or usual) for part, (load, usual) in parts.items()})

    def _with_values(self, parts):
        """`parts`: name of a pattern, or PRELOAD, to values (n,), known on every rank or distributed, and a course."""
        result = copy.copy(self)
        result.forces, result.courses = dict(self.forces), dict(self.courses)
        for name, (values, course) in parts.items():
            if name is not PRELOAD:
                loads.need_name(name)
                if result.courses.setdefault(name, course) != course:
                    raise ValueError(f"load pattern {name!r} has the course {result.courses[name]} already, not {course}; take another "
                                     "name")
            before = self.preload if name is PRELOAD else self.force if name == "force" else self.forces.get(name)
            load = self._load(values, name or "preload")
            if before is not None:
                load = load + before
            if name is PRELOAD:
                result.preload = load
            elif name == "force":
                result.force = load
            else:
                result.forces[name] = load
        return result


def is_zero(load):
    """Whether a load has no entry other than 0. Collective for PETSc."""
    return load.norm() == 0 if is_petsc(load) else not np.any(load)


def said_of(where):
    """Nodes in words, for messages."""
    if isinstance(where, str):
        return repr(where)
    where = list(where)
    return ", ".join(map(repr, where)) if where and isinstance(where[0], str) else f"the {len(where)} rows given"
