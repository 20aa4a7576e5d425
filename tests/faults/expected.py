"""The expected row of each hostile plug-in."""

from typing import NamedTuple


class Case(NamedTuple):
    """Expected columns of a plug-in's rows.

    `message` and `native` are patterns that must be found.
    """

    outcome: str
    verdict: str = "none"
    message: str = ""
    native: str = ""
    false_claim: bool = False
    files: tuple[str, ...] = ()  # settings that name a file


def _crash(native: str, message: str = ".") -> Case:
    return Case("crashed", native=f"^{native}$", message=message)


def _raised(message: str) -> Case:
    return Case("raised", message=message)


_LIE = Case("returned", "misses", false_claim=True)

CRASHES = {
    "hostile:Segfault": _crash("SIGSEGV"),
    "hostile:Abort": _crash("SIGABRT", "Assertion `x > 0' failed"),
    "hostile:Killed": _crash("SIGKILL"),
    "hostile:ExitZero": _crash("exit 0"),
    "hostile:ExitThree": _crash("exit 3", "no licence for more than 3 variables"),
    "hostile:ExitInC": _crash("exit 5"),
    "hostile:Chatty": _crash("SIGABRT", "last words"),
    "hostile:Unprintable": _crash("SIGABRT", "alert"),
    "hostile:Overflown": _crash("SIGSEGV"),
    "hostile:CrashInUnavailable": Case("crashed|unavailable", message="."),
    "hostile:Missing": Case("unavailable", message="no licence on this machine"),
    "hostile:Narrow": Case("unsupported", message="RL, not best"),
}
RAISES = {
    "hostile_answers:RaisesRude": _raised("Rude: not for you"),
    "hostile_answers:RaisesExit": _raised("SystemExit: 7"),
    "hostile_answers:RaisesInterrupt": _raised("KeyboardInterrupt: from inside"),
    "hostile_answers:RaisesSpeechless": _raised("Speechless"),
    "hostile_answers:RaisesAtLength": _raised("OSError: licence licence"),
    "hostile_answers:RaisesMarkup": _raised("OSError: .*alert"),
    "hostile_answers:RaisesInUnavailable": Case("unavailable", message="cannot say"),
    "hostile_answers:AnswersGenerator": _raised("generator; expected a Solution"),
}
ANSWERS = {
    "hostile_answers:NotANumber": _LIE,
    "hostile_answers:Elsewhere": _LIE,
    "hostile_answers:Huge": Case("returned", "optimal"),
    "hostile_answers:Wordy": Case("returned", "optimal", message="^word word"),
    "hostile_answers:WritesFile": Case("returned", "optimal"),
    "hostile_state:HangsAtExit": Case("returned", "optimal"),
    "hostile_state:ClosesStandard": Case("returned", "optimal"),
    "hostile_state:ClosesAll": Case("crashed|raised", message="."),
    "hostile_state:Floods": Case("returned", "optimal"),
    "hostile_state:ReadsStdin": Case("returned", "optimal"),
}
_LATE = Case("timeout", message=r"stopped after \d+(\.\d+)? s; the limit is 0\.5 s")
_PIDS = ("pids",)
ENDLESS = {
    "hostile_endless:LoopInC": _LATE,
    "hostile_endless:Stubborn": _LATE,
    "hostile_endless:Stopped": _LATE,
    "hostile_endless:OwnSession": _LATE,
    "hostile_endless:ForkTwo": _LATE._replace(files=_PIDS),
    "hostile_endless:ForkAndDie": _crash("SIGABRT")._replace(files=_PIDS),
    "hostile_endless:Daemon": Case("returned", "optimal", files=_PIDS),
}
# these never get past being made ready, which has a minute
STUCK = {
    "hostile_endless:LoopInWarmUp": Case("returned", "optimal"),
    "hostile_endless:LoopAlways": _LATE,
    "hostile_endless:LoopInUnavailable": Case("timeout|unavailable", message="."),
}
_MUCH = Case("out_of_memory", message=".")
MEMORY = {
    "hostile_memory:Creeping": _MUCH,
    "hostile_memory:Sudden": _MUCH,
    "hostile_memory:InChildren": _MUCH,
    "hostile_memory:Refused": _MUCH,
    "hostile_memory:OutOfMemory": Case("out_of_memory", message="tree of nodes does not fit"),
    "hostile_memory:Modest": Case("returned", "optimal"),
}
