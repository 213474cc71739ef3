"""Damping matrices of a structure or a model, which the case file takes or leaves."""


class DampingMatrices:
    """What Structure and Model have in common of them; each has `_with_matrix(name, matrix)` of its own."""

    C = K_structural = None

    def with_damping_matrix(self, C) -> "DampingMatrices":
        """The same with a viscous damping matrix [N s/m], which `damping.matrix = true` of a case takes; None for none."""
        return self._with_matrix("C", C)

    def with_structural_matrix(self, K_structural) -> "DampingMatrices":
        """The same with that in place of K [N/m] in `damping.structural`, as sum of eta_i K_i over parts; None for K."""
        return self._with_matrix("K_structural", K_structural)
