"""Surfaces that lie over each other in part: which nodes become contact points, and with what area."""

import brick
import numpy as np
import pytest

from dovetail import Joint, Structure
from dovetail.importers import setup_file


def shifted(shift, over=(4, 2, 1), under=(4, 2, 1)):
    """Blocks 2 x 1 x 1, the upper one `shift` further along x."""
    plain = [brick.grid(corner, (2, 1, 1), counts) for corner, counts in (((shift, 0, 0), over), ((0, 0, -1), under))]
    nodes = np.vstack([nodes for nodes, _ in plain])
    count = len(plain[0][0])
    cells = np.vstack([plain[0][1], plain[1][1] + count])
    K, M = brick.matrices(nodes, cells)
    above, level = np.arange(len(nodes)) < count, abs(nodes[:, 2]) < 1e-9
    sets = {"upper": np.flatnonzero(above & level), "lower": np.flatnonzero(~above & level), "bottom": np.flatnonzero(nodes[:, 2] < -0.9),
            "side": np.flatnonzero(~above & (nodes[:, 0] > 1.9))}
    return Structure(K, M, nodes, np.repeat(np.arange(len(nodes)), 3), np.tile([0, 1, 2], len(nodes)), cells={"hexahedron": cells},
                     node_sets=sets)


def joint(structure, **options):
    return Joint.between(structure.surface("upper"), structure.surface("lower"), **{"overlap": True, **options})


def test_matching_nodes_that_lie_over_each_other_are_kept_with_the_area_they_share():
    found = joint(shifted(0.5), normal_stiffness=2.0)
    assert found.kind == "pairs" and len(found) == 12 and found.left_out == 3
    assert found.position[:, 0].min() == 0.5 and found.position[:, 0].max() == 2.0
    np.testing.assert_allclose(found.area.sum(), 1.5, rtol=1e-12)
    at_rim = found.position[:, 0] == 2.0
    np.testing.assert_allclose(found.area[at_rim].sum(), 0.25, rtol=1e-12)  # half a row of faces, not a whole one
    np.testing.assert_allclose(found.contact["normal_stiffness"], 2 * found.area)
    assert "12 contact points, pairs of matching nodes; 3 more nodes do not lie over" in found.report()


def test_nodes_on_faces_are_kept_with_the_share_of_the_faces_that_lies_over_the_other_side():
    found = joint(shifted(0.75))
    assert found.kind == "faces" and len(found) == 9 and found.left_out == 6
    assert found.position[:, 0].max() == 1.75
    np.testing.assert_allclose(found.area.sum(), 1.25, rtol=1e-12)  # 2.0 - 0.75: the last row of faces counts half
    chosen = joint(shifted(0.75), at=[[1.0, 0, 0], [1.0, 1, 0]])
    assert len(chosen) == 2
    np.testing.assert_allclose(chosen.area.sum(), 1.25, rtol=1e-12)


def test_the_model_is_that_of_the_nodes_named_by_hand():
    structure = shifted(0.5)
    inside = structure.node_sets["upper"][structure.nodes[structure.node_sets["upper"], 0] <= 2]
    structure.node_sets["inside"] = inside
    by_hand = Joint.between(structure.surface("inside"), structure.surface("lower"))
    ours, theirs = structure.join([joint(structure)]), structure.join([by_hand])
    assert abs(ours.K - theirs.K).max() == 0 and np.array_equal(ours.contact_dofs, theirs.contact_dofs)


def test_a_whole_overlap_changes_nothing():
    structure = shifted(0.0)
    plain, overlapping = joint(structure, overlap=False), joint(structure)
    assert overlapping.left_out == 0 and "left out" not in overlapping.report()
    np.testing.assert_allclose(overlapping.area, plain.area)
    np.testing.assert_array_equal(overlapping.dofs, plain.dofs)


def test_nodes_that_are_held_like_their_partners_are_left_out():
    structure = shifted(0.5)
    ends = np.flatnonzero((structure.nodes[:, 0] == 0.5) & (abs(structure.nodes[:, 2]) < 1e-9))
    found = joint(structure.clamped(ends))
    assert len(found) == 9 and found.left_out == 6
    np.testing.assert_allclose(found.area.sum(), 1.5, rtol=1e-12)  # their neighbours have their area


@pytest.mark.parametrize("shift, sides, message", [
    (5.0, ("upper", "lower"), "no node of 'upper' that can move lies over 'lower'"),
    (0.25, ("upper", "side"), "no node of 'upper' that can move lies over 'side'"),
    (2.0, ("upper", "lower"), "have nodes in common, but no area")])
def test_no_overlap_is_refused(shift, sides, message):
    structure = shifted(shift)
    with pytest.raises(ValueError, match=message):
        Joint.between(*map(structure.surface, sides), overlap=True)


def test_the_message_without_it_says_how_many_and_what_to_write():
    with pytest.raises(ValueError, match=r"lies 0.5 beyond the faces of 'lower'; say overlap = true to leave out such nodes \(6 of 15\)"):
        joint(shifted(0.75, over=(4, 2, 1)), overlap=False)


def test_key_of_the_setup_file(tmp_path):
    path = tmp_path / "joints.toml"
    path.write_text('[[joint]]\nbetween = ["upper", "lower"]\noverlap = true\n')
    model = setup_file.apply(shifted(0.5), path)
    assert len(model.contact_dofs) == 12 and "3 more nodes" in model.notes[-1]
    path.write_text('[[joint]]\nbetween = ["upper", "lower"]\noverlap = "yes"\n')
    with pytest.raises(ValueError, match="overlap must be true or false, found 'yes'"):
        setup_file.apply(shifted(0.5), path)
