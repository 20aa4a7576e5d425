"""A lying plug-in that tries the conformance kit."""

from lying_dubins.lies import LIES as LIES
from lying_dubins.lies import Lying as Lying

__all__ = ["LIES", "Lying"]
