"""The topic `certificates` of the report; its one small figure is drawn in `section`."""

from dubins_study.report.topics.certificates.section import TOPIC

__all__ = ["TOPIC"]
