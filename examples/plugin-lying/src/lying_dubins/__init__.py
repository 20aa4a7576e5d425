"""A plug-in of dubins-study that lies, to try its conformance kit on."""

from lying_dubins.lies import LIES as LIES
from lying_dubins.lies import Lying as Lying

__all__ = ["LIES", "Lying"]
