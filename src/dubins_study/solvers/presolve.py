"""The presolve: words that geometry excludes before any solve.

A row that the presolve answers says so, and proves nothing for the engine.
"""

from __future__ import annotations

from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.body_coordinates import Local, local, power
from dubins_study.study.words import BRANCHES, Claim

WORDS: tuple[str, ...] = BRANCHES[1:]


def presolved(question: Question) -> Solution | None:
    """The presolve's answer to a question, or None.

    It answers only if the branch is a word that provably ends nowhere near the target.
    """
    if question.branch == "best":
        return None
    reason = unreachable(local(question.scenario), question.branch)
    if reason is None:
        return None
    message = f"presolve: {reason}"
    return Solution(Claim.INFEASIBLE, iterations=0, evaluations=0, message=message, presolved=True)


def words(branch: str, target: Local, presolve: bool) -> tuple[str, ...]:
    """The words among which to look for a path.

    With `presolve`, words that cannot exist are left out.
    """
    named = WORDS
    if branch != "best":
        named = (branch,)
    if not presolve:
        return named
    return tuple(word for word in named if unreachable(target, word) is None)


def unreachable(target: Local, word: str) -> str | None:
    """The reason that excludes a word, or None.

    C is the centre of the first turn's circle. A tangent of this circle lies outside it, so LS and
    RS end at no target inside. The second turn of LR and RL is on a circle of radius 1 whose centre
    is 2 from C: it passes only targets from 1 to 3 away from C.

    In doubt the result is None. If a reason is given, no path of the word reaches any target within
    delta of the given one (docs/derivation.md, section 5).
    """
    X, Y, delta = target
    side = Y
    if word[0] == "R":
        side = -Y
    inside = power(X, side, 0.0)
    # A target off by delta in X and in Y moves by sqrt(2) delta, and `inside` by 2 |T - C| times
    # that, where |T - C| <= 1 + |X| + |Y|. Twice as much leaves room for rounding, which moves
    # X, Y and `inside` by less than delta.
    doubt = 6.0 * delta * (1.0 + abs(X) + abs(Y))
    if inside > doubt:
        return f"the target is inside the circle of the first turn, which no {word} path enters"
    if word[1] != "S" and -inside - 8.0 > doubt:
        return f"the target is more than 3 radii from the first turn's centre, beyond any {word}"
    return None
