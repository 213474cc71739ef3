"""Forced response of small structures with frictional joints, in plain NumPy.

The same mathematics as the compiled core, written to be read: start with `law` in contact.py. Everything is dense, and the derivative
of the contact force is taken by complex step, so that nothing here shares an idea with the core except the equations.
Numbers in parentheses are equations of the theory page; units are those of the model (SI in the examples).

    reduced = craig_bampton(K, M, contact_dofs, force, preload, modes=2)
    contact = Contact.uniform(1, normal_stiffness=1.0, tangential_stiffness=1.0, friction=1.0, gap=-3.5)
    system = HarmonicBalance(reduced, contact, contact_preload(reduced, contact), 0.05, [0, 0, 1], 10, 64)
    omega, q = system.continuation(0.9, 1.3, 0.05)
"""

from .balance import Damping, HarmonicBalance
from .contact import LAWS, OPEN, STICK, Contact, analysis, contact_coefficients, contact_jacobian, law, synthesis
from .cyclic import SectorBasis, sector_basis, sector_frequencies
from .original import Original
from .reduction import Preload, Reduced, bases, contact_preload, craig_bampton, projected, split, static_law
from .sector_balance import SectorBalance

__all__ = ["Damping", "HarmonicBalance", "LAWS", "OPEN", "STICK", "Contact", "analysis", "contact_coefficients", "contact_jacobian", "law",
           "synthesis", "Original", "Preload", "Reduced", "SectorBalance", "SectorBasis", "bases", "contact_preload", "craig_bampton",
           "projected", "sector_basis", "sector_frequencies", "split", "static_law"]
