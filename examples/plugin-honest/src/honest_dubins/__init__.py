"""A plug-in of dubins-study: a solver in a package of its own."""

from honest_dubins.two_arcs import TwoArcs as TwoArcs

__all__ = ["TwoArcs"]
