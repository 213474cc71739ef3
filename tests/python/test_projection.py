"""Points on faces of 3, 4, 6 and 8 nodes: rigid motion, shape functions, gaps, distances to a curved surface."""

import brick
import numpy as np
import pytest
import scipy.sparse as sp
from lattice import lattice

from dovetail import Joint, Surface
from dovetail.projection import project


def flat(x, y):
    return 0.3 * x - 0.2 * y


def arched(x, y):
    return 0.1 * x**2 + 0.05 * x * y - 0.2 * y**2  # faces with mid-side nodes on a regular lattice reproduce it exactly


@pytest.mark.parametrize("kind, height", [(3, flat), (4, flat), (6, flat), (8, flat), (6, arched), (8, arched)])
@pytest.mark.parametrize("other", [4, 6])
def test_points_on_faces_of_every_kind(kind, height, other):
    """u_a - u_b vanishes for every rigid motion, where the points lie on b's faces exactly."""
    a = lattice((5, 3), other, height, corner=(0.1, 0.05), edges=(1.75, 0.9), up=False)
    b = lattice((3, 2), kind, height)
    joint = Joint.between(a, b)
    np.testing.assert_allclose(joint.distance, 0, atol=1e-14)
    weight = sp.csr_matrix((joint.weight, (joint.point, joint.other[:, 0] // 3)), shape=(len(a.points), len(b.points)))
    for on_a, on_b in zip(brick.rigid_motions(a.points), brick.rigid_motions(b.points)):
        np.testing.assert_allclose(weight @ on_b, on_a, atol=1e-13)


def test_weights_are_the_bilinear_ones():
    a = Surface([[0.25, 0.5, 0]], [[12, 13, 14]], name="a")
    b = lattice((1, 1), 4, lambda x, y: 0 * x, edges=(1.0, 1.0))
    joint = Joint.between(a, b, normal=[0, 0, -1])
    found = {tuple(b.points[dof // 3]): weight for dof, weight in zip(joint.other[:, 0], joint.weight)}
    wanted = {(0, 0, 0): 0.375, (1, 0, 0): 0.125, (1, 1, 0): 0.125, (0, 1, 0): 0.375}
    assert found == pytest.approx(wanted, abs=1e-15)


@pytest.mark.parametrize("kind", [3, 4, 6, 8])
def test_gaps_from_geometry(kind):
    a = lattice((4, 3), 4, lambda x, y: 0.01 + 0.002 * x, up=False, corner=(0.1, 0.1), edges=(1.5, 0.7))
    joint = Joint.between(a, lattice((3, 2), kind, lambda x, y: 0 * x), gap="geometry")
    x = a.points[:, 0]
    cosine = 1 / np.hypot(1, 0.002)
    np.testing.assert_allclose(joint.contact["gap"], (0.01 + 0.002 * x) * cosine, rtol=1e-12)
    interference = Joint.between(lattice((4, 3), 4, lambda x, y: -0.003 + 0 * x, up=False), lattice((3, 2), kind, lambda x, y: 0 * x),
                                 gap="geometry")
    np.testing.assert_allclose(interference.contact["gap"], -0.003, rtol=1e-12)


@pytest.mark.parametrize("kind", [6, 8])
def test_feet_on_a_curved_surface(kind):
    """A parabola z = x^2 / 4, which the faces reproduce: points at a distance along its normal come back to where they left."""
    b = lattice((6, 3), kind, lambda x, y: x**2 / 4, corner=(-1.0, 0.0))
    x, y = np.meshgrid(np.linspace(-0.95, 0.95, 14), np.linspace(0.05, 0.95, 7))
    start = np.stack([x, y, x**2 / 4], axis=-1).reshape(-1, 3)
    normal = np.stack([-start[:, 0] / 2, 0 * start[:, 0], np.ones(len(start))], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    for distance in (-0.2, 0.0, 0.05):
        feet = project(start + distance * normal, b)
        np.testing.assert_allclose(feet.place, start, atol=1e-9)
        np.testing.assert_allclose(feet.normal, normal, atol=1e-9)
        np.testing.assert_allclose(feet.overhang, 0, atol=1e-9)


def test_nearest_face_among_faces_of_different_size():
    """One long face beside small ones: its centre is far from points that stand on it."""
    points = np.array([(0, 0, 0), (20, 0, 0), (20, 1, 0), (0, 1, 0), (0, -1, 1), (1, -1, 1), (1, 0, 1), (0, 0, 1)], dtype=float)
    b = Surface(points, np.arange(24).reshape(-1, 3), [np.array([[0, 1, 2, 3], [4, 5, 6, 7]])])
    feet = project(np.array([(0.5, 0.01, 0.3), (0.5, -0.5, 0.6), (15, 0.5, -2)]), b)
    np.testing.assert_allclose(feet.place, [(0.5, 0.01, 0), (0.5, -0.5, 1), (15, 0.5, 0)], atol=1e-12)


def test_points_a_little_beyond_a_curved_edge_are_taken_along():
    """Up to 5 % of a face's radius, rigid motion still exact; beyond that refused, unless the tolerance allows it."""
    b = lattice((2, 2), 4, lambda x, y: 0 * x)
    radius = np.hypot(0.5, 0.25)

    def beyond(distance):
        return Surface([[2 + distance, 0.5, 0], [1.5, 0.5, 0]], [[90, 91, 92], [93, 94, 95]], name="edge")

    joint = Joint.between(beyond(0.04 * radius), b, normal=[0, 0, -1])
    assert joint.mismatch.max() == pytest.approx(0.04 * radius)
    weight = sp.csr_matrix((joint.weight, (joint.point, joint.other[:, 0] // 3)), shape=(2, 9))
    np.testing.assert_allclose(weight @ b.points, joint.position, atol=1e-14)
    with pytest.raises(ValueError, match="node 0 of 'edge' at .* beyond the faces of 'up'"):
        Joint.between(beyond(0.06 * radius), b, normal=[0, 0, -1])
    assert len(Joint.between(beyond(0.06 * radius), b, normal=[0, 0, -1], tolerance=0.07 * radius)) == 2


@pytest.mark.parametrize("corners", [
    [(0, 0), (1, 0), (0.5, 3**0.5 / 2)], [(0, 0), (1, 0), (-0.5, 0.9)], [(0, 0), (1, 0), (2, 1), (1, 1)], [(0, 0), (1, 0), (3, 1), (2, 1)]])
def test_overhang_of_skewed_faces_is_the_distance_to_the_edge(corners):
    """A point 0.02 beyond the middle of each edge, in the plane of the face."""
    corners = np.array(corners)
    edges = np.roll(corners, -1, axis=0) - corners
    outward = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1, keepdims=True)
    points = np.pad(corners + edges / 2 + 0.02 * outward, ((0, 0), (0, 1)))
    face = Surface(np.pad(corners, ((0, 0), (0, 1))), np.arange(3 * len(corners)).reshape(-1, 3), [[np.arange(len(corners))]])
    np.testing.assert_allclose(project(points, face).overhang, 0.02, rtol=1e-9)
