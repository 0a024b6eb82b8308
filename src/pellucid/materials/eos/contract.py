"""The interface of an equation of state to a fluid."""

from abc import abstractmethod

from pellucid.materials.law import Law
from pellucid.model import Model


class EquationOfStateModel(Model):
    """An equation of state: the user's parameters, and its law. A new one is a subclass with a `kind` of its own."""

    kind: str

    @abstractmethod
    def law(self, density: float, pressure: float) -> Law:
        """The law as kernels take it, of a fluid with this density [kg/m³] and pressure [Pa] at the start."""
