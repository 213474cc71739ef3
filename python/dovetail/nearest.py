"""Trees that find the nearest of many points."""


def tree(points):
    """scipy.spatial.cKDTree of points (n, 3). Imported only where one is asked for: every start of Python would wait for it."""
    from scipy.spatial import cKDTree

    return cKDTree(points)
