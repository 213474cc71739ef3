"""Contact points of a sector, by the nodes on both sides: inside the sector, and to the next one."""

import numpy as np

ROUNDING = 1e-12  # weights below are round-off of a point on the edge of a face


def contacts_of(joints, structure):
    """`nodes`, `next_sector` and `faces` of the `cyclic` of Model.

    Raises ValueError when a contact node is taken twice, lies on left or right, or when a joint stands on contact nodes.
    """
    a = [_nodes(joint.dofs, structure) for joint in joints]
    b = [_nodes(joint.other, structure) if joint.kind == "pairs" else np.full(len(joint), -1) for joint in joints]
    _need_once(joints, a, b, structure.labels)
    shapes = [_on_faces(joint, structure) if joint.kind == "faces" else (np.empty(0, dtype=np.int64),) * 2 + (np.empty(0),)
              for joint in joints]
    for joint, *nodes, (_, on, _) in zip(joints, a, b, shapes):
        _need_inside(joint, np.concatenate([*nodes, on]), structure)
    taken = np.concatenate([*a, *b])
    for joint, (_, node, _) in zip(joints, shapes):
        both = np.intersect1d(node, taken)
        if both.size:
            raise ValueError(f"joint {joint.name!r} stands on a face with node {structure.labels[both[0]]}, a contact point itself "
                             f"({len(both)} such nodes); in a sector a node has one part only: let these faces be the first side, or leave "
                             "the node out of the other joint")
    first = np.cumsum([0, *(len(joint) for joint in joints)])
    point, node, weight = (np.concatenate(parts) for parts in zip(*((start + point, node, weight)
                                                                     for start, (point, node, weight) in zip(first, shapes))))
    order = np.argsort(point, kind="stable")
    begin = np.searchsorted(point[order], np.arange(first[-1] + 1))
    return {"nodes": np.column_stack([np.concatenate(a), np.concatenate(b)]),
            "next_sector": np.repeat([int(joint.next_sector) for joint in joints], [len(joint) for joint in joints]),
            "faces": {"begin": begin, "node": node[order], "weight": weight[order]}}


def _nodes(dofs, structure):
    """Node row (m,) of the dofs (m, 3) of each, -1 where it is held."""
    dof = dofs.max(axis=1, initial=-1)
    return np.where(dof >= 0, structure.dof_node[dof], -1)


def _on_faces(joint, structure):
    """Point, node row and weight of what the contact points stand on, held nodes left out."""
    node = _nodes(joint.other, structure)
    moves = (node >= 0) & (np.abs(joint.weight) > ROUNDING)
    return joint.point[moves], node[moves], joint.weight[moves]


def _need_once(joints, a, b, labels):
    number = np.repeat(np.arange(len(joints)), [len(one) for one in a])
    nodes, owner = np.concatenate([*a, *b]), np.tile(number, 2)
    nodes, owner = nodes[nodes >= 0], owner[nodes >= 0]
    order = np.argsort(nodes, kind="stable")
    twice = np.flatnonzero(np.diff(nodes[order]) == 0)
    if twice.size:
        names = list(dict.fromkeys(joints[k].name for k in owner[order[twice[0]:twice[0] + 2]]))
        wanted = f"joints {names[0]!r} and {names[1]!r} both take" if len(names) > 1 else f"joint {names[0]!r} takes twice"
        raise ValueError(f"{wanted} node {labels[nodes[order[twice[0]]]]}; a node can be a contact point once: leave it out of one of the "
                         "sets")


def _need_inside(joint, nodes, structure):
    cyclic = structure.cyclic_sector
    for rows, name in ((cyclic.left, cyclic.left_name), (cyclic.right, cyclic.right_name)):
        found = np.intersect1d(nodes, rows)
        if found.size:
            raise ValueError(f"joint {joint.name!r} has node {structure.labels[found[0]]} of {name!r} ({len(found)} such nodes), where the "
                             "sector is joined to its neighbour; take it out of the joint's set, or out of left and right")
