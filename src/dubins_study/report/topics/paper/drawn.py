"""The topic on the paper's figures."""

from __future__ import annotations

from dubins_study.report.elements.content import Place
from dubins_study.report.elements.topic import Topic
from dubins_study.report.topics.paper.section import figures_section

TOPIC = Topic("the paper's figures", figures_section, "paper", place=Place.PAPER)
