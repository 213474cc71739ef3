"""Harmonic loads of Nastran's bulk data: RLOAD1 and RLOAD2 with DAREA, FORCE and MOMENT, phases by DPHASE."""

import cmath
import math

import numpy as np

from .inp_sets import Entry


class NotTaken(Exception):
    """What stands in the way of a load."""


def keep_second_points(model):
    """Let the model, before it reads, keep both grid points of a DAREA card: pyNastran passes over the second one."""
    kind, add = model._card_parser["DAREA"]

    class Both:
        @staticmethod
        def add_card(card, comment=""):
            area = kind.add_card(card, comment=comment)
            if card.field(5):
                area.add(kind.add_card(card, icard=1))
            return area

    model._card_parser["DAREA"] = Both, add


def take_loads(model, deck):
    """Fills `loads` and `late_loads`, real and imaginary parts, by the DLOAD that the case control section selects.

    All other loads, and the one selected if a part of it is not known or varies with the frequency, go into `other_loads`.
    """
    selected = sorted({values for subcase in model.subcases.values() for key, (values, *_) in subcase.params.items() if key == "DLOAD"})
    others = sorted({*model.dloads, *model.dload_entries})
    used = set()
    if len(selected) > 1:
        deck.other_loads.append(f"DLOAD {', '.join(map(str, selected))} (wanted one in the case control section)")
    elif selected:
        try:
            _fill(deck, [part for load in _parts(model, selected[0], 1.0, used) for part in load])
            others = [number for number in others if number not in used]
        except NotTaken as reason:
            deck.other_loads.append(f"DLOAD {selected[0]} ({reason})")
            others, used = [number for number in others if number not in used], {selected[0]}
    deck.other_loads += [f"load set {number}" for number in sorted(model.loads) if number not in used]
    deck.other_loads += [f"dynamic load {number}" for number in others]


def _parts(model, number, factor, used):
    """Lists of (grid point, direction from 1, complex value, name of the card) of a set of dynamic loads."""
    used.add(number)
    for combination in model.dloads.get(number, []):
        for scale, member in zip(combination.scale_factors, combination.load_ids):
            if member not in model.dload_entries:
                raise NotTaken(f"there is no RLOAD1 or RLOAD2 {member}")
            yield from _parts(model, member, factor * combination.scale * scale, used)
    for load in model.dload_entries.get(number, []):
        if load.type not in ("RLOAD1", "RLOAD2") or load.Type != "LOAD":
            raise NotTaken(f"{load.type} {number} is no force that varies as a sine")
        if load.delay not in (None, 0):
            raise NotTaken(f"{load.type} {number} has a DELAY, so that its phase varies with the frequency")
        if load.type == "RLOAD1":
            size = complex(_constant(model, load.tc, load), _constant(model, load.td, load))
        else:
            size = cmath.rect(_constant(model, load.tb, load), math.radians(_constant(model, load.tp, load)))
        yield [(*place, factor * size * value * _turned(model, load, place), f"{load.type} {number}")
               for place, value in _pattern(model, load, used)]
    if number not in model.dloads and number not in model.dload_entries:
        raise NotTaken("there is no such card")


def _constant(model, given, load):
    """A number, or the one value of a table."""
    if given in (None, 0):
        return 0.0
    if isinstance(given, float):
        return given
    table = model.tables_d.get(given)
    if table is None or table.type not in ("TABLED1", "TABLED2") or np.ptp(table.y) != 0:
        raise NotTaken(f"{load.type} {load.sid} asks for table {given}, which is not one constant TABLED1 or TABLED2")
    return float(table.y[0])


def _turned(model, load, place):
    """exp(i phase) of the grid point and direction; DPHASE is in degrees."""
    if isinstance(load.dphase, float) or load.dphase in (None, 0):
        return cmath.exp(1j * math.radians(load.dphase or 0))
    card = model.dphases.get(load.dphase)
    if card is None:
        raise NotTaken(f"{load.type} {load.sid} asks for DPHASE {load.dphase}, which is not there")
    degrees = {(grid, max(int(c), 1)): phase for grid, c, phase in zip(card.nodes, card.components, card.phase_leads)}
    return cmath.exp(1j * math.radians(degrees.get(place) or 0))


def _pattern(model, load, used):
    """((grid point, direction from 1), value) of DAREA, FORCE and MOMENT cards."""
    number = load.excite_id
    areas, forces = model.dareas.get(number), model.loads.get(number, [])
    if areas is None and not forces:
        raise NotTaken(f"{load.type} {load.sid} excites DAREA or load set {number}, which is not there")
    for card in [areas] if areas is not None else []:
        for grid, component, scale in zip(card.nodes, card.components, card.scales):
            yield (grid, max(int(component), 1)), scale
    for card in forces:
        if card.type not in ("FORCE", "MOMENT") or card.cid != 0:
            raise NotTaken(f"load set {number} has {card.type}" + (f" in coordinate system {card.cid}" if getattr(card, "cid", 0) else ""))
        used.add(number)
        for axis, part in enumerate(card.xyz, start=4 if card.type == "MOMENT" else 1):
            yield (card.node, axis), card.mag * part


def _fill(deck, parts):
    sums = {}
    for grid, direction, value, card in parts:
        before = sums.get((grid, direction), (0, card))[0]
        sums[grid, direction] = before + value, card
    largest = max((abs(value) for value, _ in sums.values()), default=0)
    rows = {grid: deck.rows_of([grid]) for grid, _ in sums}
    for grid, row in rows.items():
        if row[0] < 0:
            raise NotTaken(f"grid point {grid} is not there")
    for (grid, direction), (value, card) in sums.items():
        for part, loads in ((value.real, deck.loads), (value.imag, deck.late_loads)):
            if abs(part) > 1e-14 * largest:  # what sine and cosine leave of a right angle
                loads.append(Entry(rows[grid], direction, direction, part, 0, f"{deck.path}, {card}", card=card))
