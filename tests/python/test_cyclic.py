"""Sectors of a disk: matching of both sides, joints to the next sector, what is written, and everything that is refused."""

import brick
import h5py
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from ring import N, sector, whole, with_rotations

from dovetail import Joint, Model
from dovetail.followers import Followers
from dovetail.info import describe
from dovetail.reference import sector_basis, sector_frequencies

Z = (0, 0, 1)
STIFF = {"normal_stiffness": 1e3, "tangential_stiffness": 5e2, "friction": 0.3}


def cyclic(structure=None, **more):
    return (structure or sector()).cyclic(N, "left", "right", Z, **more)


def shroud(structure, **more):
    """The contact of this sector's right side with the next one's left side."""
    return Joint.between(structure.surface("over_right"), structure.surface("over_left"), **{**STIFF, "next_sector": True, **more})


def joined(structure):
    return structure.join(shroud(structure))


def refused(call, *words):
    with pytest.raises(ValueError) as error:
        call()
    for word in words:
        assert word in str(error.value), f"{word!r} is not in: {error.value}"


def test_partners_lie_one_turn_apart_about_any_axis():
    tilt = brick.turned((1, 2, -1), 0.7, (5.0, -2.0, 1.0))
    structure = sector(mapping=tilt)
    axis = tilt(np.eye(3)[[2]])[0] - tilt(np.zeros((1, 3)))[0]
    found = structure.cyclic(N, "left", "right", 3 * axis, origin=tilt(np.array([[0, 0, 7.0]]))[0]).cyclic_sector
    turned = brick.turned(axis, 2 * np.pi / N)
    centre = tilt(np.zeros((1, 3)))
    np.testing.assert_allclose(structure.nodes[found.right], centre + turned(structure.nodes[found.left] - centre), atol=1e-12)
    assert len(found.left) == len(structure.node_sets["left"]) == 9 and found.axis @ found.axis == pytest.approx(1)


@pytest.mark.parametrize("shift, kind", [(0.0, "pairs"), (0.3, "faces")])
def test_rigid_motion_of_the_ring_costs_nothing_at_any_nodal_diameter(tmp_path, shift, kind):
    """Spin and axial motion are waves of index 0, motion across and tilting of index 1; stuck contacts follow them all."""
    structure = cyclic(sector(shift=shift))
    joint = shroud(structure)
    assert joint.kind == kind and "to the next sector" in joint.report()
    structure.join(joint).write(tmp_path / "model.h5")
    model = Model.read(tmp_path / "model.h5")
    lowest = [sector_frequencies(model, h, 4) for h in range(N // 2 + 1)]
    scale = lowest[2][0]
    for h, rigid in ((0, 2), (1, 2), (2, 0)):
        assert np.all(lowest[h][:rigid] < 1e-5 * scale) and np.all(lowest[h][rigid:] > 0.1 * scale), lowest
    across = np.zeros((len(model.mesh["nodes"]), 3), dtype=complex)
    across[:, :2] = 1, -1j  # sector j has R^-j of it, exp(-i j phi) of sector 0 with h = 1 or -1
    h = 1 if np.allclose(np.array([[np.cos(2 * np.pi / N), np.sin(2 * np.pi / N)]]) @ [1, -1j], np.exp(-2j * np.pi / N)) else -1
    basis = sector_basis(model, h)
    q = np.linalg.lstsq(basis.matrix.toarray(), across.ravel(), rcond=None)[0]
    np.testing.assert_allclose(basis.matrix @ q, across.ravel(), atol=1e-12)
    np.testing.assert_allclose(q[basis.contact], 0, atol=1e-12)


@pytest.mark.parametrize("shift, kind", [(0.0, "pairs"), (0.3, "faces")])
def test_all_nodal_diameters_are_the_ring_assembled_and_joined(shift, kind):
    """The whole ring is joined sector by sector with the coordinates that models without cyclic symmetry have."""
    ring = whole(shift=shift).clamped("bore")
    joints = [Joint.between(ring.surface(f"over_right_{j}"), ring.surface(f"over_left_{(j + 1) % N}"), **STIFF) for j in range(N)]
    assert {joint.kind for joint in joints} == {kind}
    assembled = ring.join(joints)
    springs = np.zeros(assembled.n)
    springs[assembled.contact_dofs] = np.column_stack([assembled.contact["tangential_stiffness"], assembled.contact["normal_stiffness"]])
    K, M = (assembled.K + sp.diags(springs)).toarray(), assembled.M.toarray()
    wanted = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True))
    model = joined(cyclic(sector(shift=shift).clamped("bore")))
    parts = [sector_frequencies(model, h, model.n) for h in range(N // 2 + 1)]
    found = np.sort(np.concatenate(parts + parts[1:]))
    assert len(found) == assembled.n
    np.testing.assert_allclose(found, wanted, rtol=1e-10)


def test_what_is_written_is_read(tmp_path):
    structure = cyclic(sector(shift=0.3).clamped("bore"))
    model = structure.join([shroud(structure, name="cover")])
    model.write(tmp_path / "model.h5")
    again = Model.read(tmp_path / "model.h5")
    for key, values in model.cyclic.items():
        if key == "faces":
            for part in values:
                np.testing.assert_array_equal(again.cyclic["faces"][part], values[part])
        else:
            np.testing.assert_array_equal(again.cyclic[key], values)
    assert again.contact_dofs is None and again.contact_points == len(again.joint["position"]) == 6
    assert np.array_equal(again.cyclic["nodes"][:, 1], np.full(6, -1)) and again.cyclic["next_sector"].all()
    np.testing.assert_allclose(np.add.reduceat(again.cyclic["faces"]["weight"], again.cyclic["faces"]["begin"][:-1]), 1)
    assert abs(again.K - structure.K).max() < 1e-14 * abs(structure.K).max() and len(again.mesh["changed"]["dof"]) == 0
    held = structure.node_sets["bore"]
    table = structure.dofs_of(np.setdiff1d(structure.node_sets["left"], held))
    assert sorted(again.cyclic["left"].ravel()) == sorted(table.ravel())


@pytest.mark.parametrize("held, free", [("over_left", "over_right"), ("over_right", "over_left")])
def test_a_side_that_is_held_is_ground(held, free):
    """With equal stiffnesses a stuck point is a spring at the side that can move."""
    structure = cyclic(sector().clamped(held))
    joint = shroud(structure, tangential_stiffness=1e3)
    model = structure.join(joint)
    nodes = model.cyclic["nodes"]
    assert np.array_equal(nodes.min(axis=1), np.full(6, -1)) and set(nodes.max(axis=1)) == set(structure.node_sets[free])
    springs = np.zeros(structure.n)
    springs[structure.dofs_of(nodes.max(axis=1))] = model.contact["normal_stiffness"][:, None]
    supported = structure._with_matrix("K", structure.K + sp.diags(springs)).join(joint)
    for h in range(N // 2 + 1):
        np.testing.assert_allclose(sector_frequencies(model, h, 12), sector_frequencies(supported, h, 12, "open"), rtol=1e-10)


def test_info_says_what_the_sector_is(tmp_path):
    joined(cyclic(sector().clamped("bore", "z"))).write(tmp_path / "model.h5")
    said = describe(tmp_path / "model.h5")
    assert "5 sectors about the axis (0, 0, 1); 24 dofs on either side" in said and "6, 6 of them to the next sector" in said


def test_damaged_files_are_refused(tmp_path):
    path = tmp_path / "model.h5"
    joined(cyclic()).write(path)
    for name, value, words in (("sectors", 1, "a whole number from 2 on, found 1"), ("sectors", "five", "must be one whole number"),
                               ("axis", [0.0, 0.0, 2.0], "axis must be a unit vector"), ("axis", "z", "axis must be three numbers")):
        with h5py.File(path, "r+") as file:
            before = file["cyclic"].attrs[name]
            file["cyclic"].attrs[name] = value
        refused(lambda: Model.read(path), str(path), words)
        with h5py.File(path, "r+") as file:
            file["cyclic"].attrs[name] = before
    for name, change, words in (("cyclic/left", lambda old: old + 10000, "left and right must be dofs 0 to"),
                                ("cyclic/right", lambda old: old[:-1], "held on both sides alike"),
                                ("cyclic/next_sector", lambda old: old + 1, "next_sector must be 0 or 1"),
                                ("contact/nodes", lambda old: old - 1000, "nodes must be (N_x, 2) node rows")):
        with h5py.File(path, "r+") as file:
            before = file[name][()]
            del file[name]
            file[name] = change(before)
        refused(lambda: Model.read(path), words)
        with h5py.File(path, "r+") as file:
            del file[name]
            file[name] = before
    Model.read(path)


def test_directions_that_the_turn_keeps_may_be_clamped():
    along, across = sector().clamped("bore", "z"), sector().clamped("bore", "xy")
    for structure, held in ((along, [2]), (across, [0, 1])):
        model = joined(cyclic(structure))
        for side in ("left", "right"):
            missing = model.cyclic[side][(model.cyclic[side] < 0).any(axis=1)] < 0
            assert len(missing) == 3 and np.array_equal(np.flatnonzero(missing.all(axis=0)), held) and missing.sum() == 3 * len(held)


def test_rotations_have_rows_of_their_own():
    plain = sector()
    rows = np.concatenate([plain.node_sets["left"], plain.node_sets["right"]])
    model = joined(cyclic(with_rotations(plain, rows)))
    assert model.cyclic["left"].shape == (18, 3)
    assert set(model.mesh["dof_direction"][model.cyclic["right"][9:]].ravel()) == {3, 4, 5}


@pytest.mark.parametrize("sectors", [1, 0, -6, 12.0, True, "12", 10**400])
def test_sectors_are_a_whole_number_from_two_on(sectors):
    refused(lambda: sector().cyclic(sectors, "left", "right", Z),
            f"sectors must be a whole number from 2 on, of at most 1000000, found {sectors!r}")


@pytest.mark.parametrize("axis, origin, words", [((0, 0, 0), (0, 0, 0), "axis must not be zero"),
                                                 ((0, 1), (0, 0, 0), "axis must be a vector of three finite numbers"),
                                                 (Z, (0, np.nan, 0), "origin must be a vector of three finite numbers"),
                                                 (Z, (1e200, 0, 0), "origin must be a point on the axis near the mesh"),
                                                 (Z, (1e8, 0, 0), "origin must be a point on the axis near the mesh")])
def test_axis_and_origin_are_vectors(axis, origin, words):
    refused(lambda: sector().cyclic(N, "left", "right", axis, origin=origin), words)


@pytest.mark.parametrize("length", [1e-320, 1e-200, 1e200])
def test_the_length_of_the_axis_does_not_matter(length):
    assert np.array_equal(sector().cyclic(N, "left", "right", (0, 0, length)).cyclic_sector.axis, Z)


def test_tolerance_is_a_number():
    refused(lambda: cyclic(tolerance=-1.0), "tolerance must be a finite number that is not negative [m], found -1.0")


def test_faces_at_another_angle():
    refused(lambda: cyclic(sector(angle=np.radians(71.99))), "'left' and 'right' are 71.99 degrees apart, 5 sectors need 72")
    refused(lambda: sector().cyclic(4, "left", "right", Z), "are 72 degrees apart, 4 sectors need 90; sectors = 5?")


def test_left_and_right_exchanged():
    refused(lambda: sector().cyclic(N, "right", "left", Z), "'left' is 'right' turned by minus 72 degrees", "exchange left and right")
    assert len(sector().cyclic(N, "right", "left", (0, 0, -1)).cyclic_sector.left) == 9


def test_unequal_counts():
    structure = sector()
    structure.node_sets["right"] = structure.node_sets["right"][1:]
    gone = structure.labels[structure.node_sets["left"][0]]
    refused(lambda: cyclic(structure), "'left' has 9 nodes off the axis and 'right' has 8", f"node {gone} of 'left' has none within")
    refused(lambda: structure.cyclic(N, "right", "left", (0, 0, -1)), f"node {gone} of 'left' has none within")


def test_no_partner_within_the_tolerance():
    structure = sector()
    moved = structure.node_sets["right"][4]
    structure.nodes[moved] += [0, 0, 1e-3]
    partner = structure.labels[structure.node_sets["left"][4]]
    refused(lambda: cyclic(structure), f"node {partner} of 'left', turned by 72 degrees, lies 0.001 from the nearest node of 'right', "
            f"{structure.labels[moved]}", "1 above the tolerance", "raise the tolerance")
    assert len(cyclic(structure, tolerance=2e-3).cyclic_sector.left) == 9


def test_tolerance_larger_than_the_mesh():
    structure = sector()
    structure.nodes[structure.node_sets["right"][0]] += [0, 0, 0.6]
    refused(lambda: cyclic(structure, tolerance=0.6), "is the partner of 2 nodes of 'left'", "smaller than the distance between nodes")


def test_a_node_on_both_sides():
    structure = sector()
    shared = structure.node_sets["left"][0]
    structure.node_sets["right"] = np.append(structure.node_sets["right"], shared)
    refused(lambda: cyclic(structure), f"node {structure.labels[shared]} is in 'left' and in 'right' (1 such nodes)")


def on_the_axis():
    """A sector that reaches to the axis: two of its nodes lie there, in both sets."""
    structure = sector()
    for k, z in enumerate((0.0, 1.0)):
        row = structure.node_sets["bore"][k]
        structure.nodes[row] = 0, 0, z
        for side in ("left", "right"):
            structure.node_sets[side] = np.setdiff1d(structure.node_sets[side], structure.node_sets["bore"])
    for side in ("left", "right"):
        structure.node_sets[side] = np.append(structure.node_sets[side], structure.node_sets["bore"][:2])
    return structure


def test_a_node_on_the_axis_that_can_move():
    structure = cyclic(on_the_axis())
    first = structure.labels[structure.node_sets["bore"][0]]
    refused(lambda: joined(structure), f"node {first} lies on the axis and can move (2 such nodes", "clamp what lies on the axis")
    assert len(joined(cyclic(on_the_axis().clamped("bore"))).cyclic["left"]) == 6


def test_only_nodes_on_the_axis():
    structure = on_the_axis()
    structure.node_sets["right"] = structure.node_sets["bore"][:2]
    refused(lambda: cyclic(structure), "no node of 'right' is off the axis")


def test_a_partner_clamped_on_one_side_or_in_other_directions():
    structure = sector()
    a, b = (structure.node_sets[side][:1] for side in ("left", "right"))
    names = f"node {structure.labels[a[0]]} of 'left' can move along", f"node {structure.labels[b[0]]} of 'right'"
    refused(lambda: joined(cyclic(structure.clamped(a))), names[0] + " nothing", names[1] + ", along x, y, z (1 such pairs)",
            "clamp both alike")
    refused(lambda: joined(cyclic(structure.clamped(a, "z").clamped(b, "y"))), names[0] + " x, y", names[1] + ", along x, z")


def test_a_clamp_that_the_turn_does_not_keep():
    refused(lambda: joined(cyclic(sector().clamped("bore", "x"))), "of 'left' can move along y, z only (3 such nodes)",
            "a turn by 72 degrees does not keep these directions")


def test_sides_that_are_held_altogether():
    refused(lambda: joined(cyclic(sector().clamped(["left", "right"]))), "every node of 'left' and 'right' is clamped")


def test_rotations_on_one_side_only():
    plain = sector()
    refused(lambda: joined(cyclic(with_rotations(plain, plain.node_sets["left"]))), "along x, y, z, rotation x, rotation y, rotation z",
            "both sides need the same kind of elements")


def test_matrices_that_hold_the_constraint():
    """As a penalty between the sides, as unknowns that are gone, or as equations."""
    structure = cyclic()
    pairs = structure.cyclic_sector
    left, right = structure.dofs_of(pairs.left).ravel(), structure.dofs_of(pairs.right).ravel()
    R = sp.block_diag([pairs.rotation] * len(pairs.left))
    apart = sp.csr_matrix((np.ones(len(right)), (np.arange(len(right)), right)), shape=(len(right), structure.n))
    apart = apart - R @ sp.csr_matrix((np.ones(len(left)), (np.arange(len(left)), left)), shape=(len(left), structure.n))
    penalty = structure._with_matrix("K", structure.K + 1e6 * (apart.T @ apart))
    refused(lambda: joined(penalty), "a rigid motion needs forces at 27 of 27 unknowns of 'left'", "write those of the plain sector")
    refused(lambda: joined(cyclic(sector().clamped("right"))), "bring matrices of the plain sector, without the constraint")
    tied = cyclic(sector().clamped("right"))
    table = np.full((len(tied.nodes), 3), -1)
    table[tied.node_sets["right"]] = np.arange(27).reshape(9, 3)
    tied.followers = Followers(table, sp.csr_matrix((27, tied.n)))
    refused(lambda: joined(tied), "of 'right' follows others by an equation", "matrices of the plain sector are wanted")


def test_contact_nodes_on_a_side():
    structure = cyclic()
    structure.node_sets["left_face"] = np.concatenate([structure.node_sets["left"], structure.node_sets["over_left"]])
    joint = Joint.between(structure.surface("right_face"), structure.surface("left_face"), **STIFF, next_sector=True)
    refused(lambda: structure.join(joint), "'right_face - left_face' has node", "of 'left' (9 such nodes)",
            "where the sector is joined to its neighbour")


def test_faces_that_share_a_node_with_a_side():
    structure = cyclic(sector(shift=0.3))
    structure.node_sets["left_face"] = np.concatenate([structure.node_sets["left"], structure.node_sets["over_left"]])
    joint = Joint.between(structure.surface("over_right"), structure.surface("left_face"), **STIFF, next_sector=True)
    assert joint.kind == "faces"
    model = structure.join(joint)  # no contact point stands on the faces below
    assert not set(model.cyclic["faces"]["node"]) & set(structure.cyclic_sector.left)
    rows = structure.node_sets["over_right"]
    low = rows[np.hypot(*structure.nodes[rows, :2].T) < 2.6]
    structure.nodes[low, :2] *= 0.9  # to where faces below reach
    joint = Joint.between(structure.surface("over_right"), structure.surface("left_face"), **STIFF, next_sector=True)
    refused(lambda: structure.join(joint), "of 'left' (3 such nodes), where the sector is joined to its neighbour")


def test_a_node_is_a_contact_point_once():
    structure = cyclic()
    first = structure.labels[structure.node_sets["over_right"][0]]
    refused(lambda: structure.join([shroud(structure, name="one"), Joint.ground(structure.surface("over_right"), name="two", **STIFF)]),
            f"joints 'one' and 'two' both take node {first}")


def test_faces_with_contact_nodes_of_another_joint():
    structure = cyclic(sector(shift=0.3))
    refused(lambda: structure.join([shroud(structure, name="one"), Joint.ground(structure.surface("over_left"), name="two", **STIFF)]),
            "joint 'one' stands on a face with node", "a contact point itself")


def test_a_joint_to_the_next_sector_of_what_is_not_cyclic():
    refused(lambda: shroud(sector()), "surface 'over_left' is that of a structure that is not cyclic")
    refused(lambda: sector().join(shroud(cyclic())), "leads to the next sector, and this structure is not cyclic")


def test_checks_of_joints_apply_to_the_next_sector():
    structure = cyclic()
    refused(lambda: Joint.between(structure.surface("over_left"), structure.surface("over_right"), next_sector=True, **STIFF),
            "beyond the faces of 'over_right of the next sector'")
    np.testing.assert_allclose(shroud(structure, gap="geometry").contact["gap"], 0, atol=1e-12)


@pytest.mark.parametrize("after", [False, True])
def test_inertia_across_the_axis_is_refused(after):
    """Whether the loads come before or after the structure is made a sector."""
    def made(load):
        return joined(load(cyclic()) if after else cyclic(load(sector())))

    refused(lambda: made(lambda structure: structure.with_gravity([0, 1, 0])),
            "the weight under [0.0, 1.0, 0.0] is not the same on every sector; it must act along the axis, (0, 0, 1)")
    refused(lambda: made(lambda structure: structure.with_base_acceleration([1, 0, 1], name="shaker")), "the base motion 'shaker' along [")
    both = made(lambda structure: structure.with_gravity([0, 1, 2]).with_gravity([0, -1, 0]).with_base_acceleration([0, 0, 1]))
    assert both.preload[2::3].min() > 0 > both.forces["base"][2::3].max()


@pytest.mark.parametrize("key, change, words", [
    ("sectors", lambda _: 5.7, "cyclic sectors must be a whole number from 2 on, found 5.7"),
    ("sectors", lambda _: np.nan, "cyclic sectors must be a whole number from 2 on, found nan"),
    ("sectors", lambda _: np.inf, "cyclic sectors must be a whole number from 2 on, found inf"),
    ("sectors", lambda _: 1, "cyclic sectors must be a whole number from 2 on, found 1"),
    ("nodes", lambda nodes: np.concatenate([nodes[:-1], nodes[:1]]), "cyclic nodes must name each contact node once, found node row"),
    ("nodes", lambda nodes: nodes[:, [0, 0]], "cyclic nodes must name each contact node once, found node row"),
])
def test_a_model_refuses_a_sector_that_does_not_hold(key, change, words):
    model = joined(cyclic())

    def with_cyclic(cyclic):
        return Model(model.K, model.M, contact_dofs=None, force=model.force, preload=model.preload, contact=model.contact,
                     mesh=model.mesh, joint=model.joint, cyclic=cyclic)

    assert with_cyclic(model.cyclic).cyclic["sectors"] == N
    refused(lambda: with_cyclic(model.cyclic | {key: change(model.cyclic[key])}), words)
