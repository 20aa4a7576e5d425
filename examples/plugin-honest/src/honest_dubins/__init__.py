"""A solver in a package of its own: a plug-in."""

from honest_dubins.two_arcs import TwoArcs as TwoArcs

__all__ = ["TwoArcs"]
