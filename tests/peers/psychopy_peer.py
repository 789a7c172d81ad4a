"""PsychoPy's staircase, QUEST and Psi on fixed answers; the numbers are held by tests in experiments/src/procedures.

PsychoPy itself needs a graphics stack to import. Only three of its modules are run here, from the unpacked wheel: the two
contributed engines stand alone, and of `psychopy.data.staircase` the class StairHandler, with its logging stubbed.

    pip download psychopy==2026.2.5 --no-deps && python3 -m zipfile -e psychopy-2026.2.5-*.whl unpacked
    python3 psychopy_peer.py unpacked
"""

import ast
import importlib.util
import pathlib
import sys
import types

import numpy as np

unpacked = pathlib.Path(sys.argv[1])


def engine(name):
    path = unpacked / "psychopy" / "contrib" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def stair_handler():
    """The class out of its module, with a base class that stores nothing."""
    source = (unpacked / "psychopy" / "data" / "staircase.py").read_text()
    wanted = [n for n in ast.parse(source).body if isinstance(n, ast.ClassDef) and n.name == "StairHandler"]
    base = type("_BaseTrialHandler", (), {
        "getOriginPathAndFile": lambda self, path: ("", ""),
        "getExp": lambda self: None,
        "_terminate": lambda self: None,
    })
    names = {"_BaseTrialHandler": base, "logging": types.SimpleNamespace(warn=print), "np": np}
    exec(compile(ast.Module(wanted, []), "staircase.py", "exec"), names)
    return names["StairHandler"]


def answers(count, percent):
    """The linear congruential generator of the Rust test."""
    state, out = 12345, []
    for _ in range(count):
        state = (1103515245 * state + 12345) % 2**31
        out.append(int(state // 65536 % 100 < percent))
    return out


print("# StairHandler: n_up, n_down, initial rule, step type, sum of level x trial number, reversals, last level")
Stair = stair_handler()
for n_up, n_down, initial, kind, name in [
    (1, 2, True, "lin", "Linear"), (1, 3, True, "log", "Log"), (2, 3, True, "db", "Db"), (1, 3, False, "log", "Log"),
    (2, 1, False, "lin", "Linear"), (1, 1, True, "log", "Log"), (3, 4, False, "db", "Db"),
]:
    stair = Stair(2.0, nReversals=4, stepSizes=[0.3, 0.2, 0.1, 0.05], nTrials=120, nUp=n_up, nDown=n_down,
                  applyInitialRule=initial, stepType=kind, minVal=0.05, maxVal=4.0)
    for answer in answers(120, 72):
        next(stair)
        stair.addResponse(answer)
    total = sum(level * number for number, level in enumerate(stair.intensities, 1))
    print(f"({n_up}, {n_down}, {str(initial).lower()}, StepType::{name}, {total:.9f}, "
          f"{len(stair.reversalIntensities)}, {stair.intensities[-1]:.9f}),")

print("# QuestObject: start 50, SD 50, p .82, beta 3.5, delta .01, gamma .5, grain .01, range 100")
quest = engine("quest").QuestObject(50, 50, 0.82, 3.5, 0.01, 0.5, grain=0.01, range=100)
level, levels = 50, []
for answer in [1, 1, 0, 0, 1, 1, 0, 0, 1, 1]:
    levels.append(float(level))
    quest.update(level, answer)
    level = quest.quantile()
print(levels, quest.mean(), quest.mode()[0], quest.quantile(), quest.sd())

print("# PsiObject: levels -5..5 by .25, thresholds -4..4 by .25, SD .5..3 by .25, 2AFC, delta .04")
psi = engine("psi").PsiObject((-5, 5), (-4, 4), (0.5, 3), 0.25, 0.25, 0.25, delta=0.04, TwoAFC=True)
psi.update()
levels = []
for answer in [1, 1, 0, 1, 0, 1, 1, 1, 0, 1, 1, 1]:
    levels.append(float(psi.nextIntensity))
    psi.update(answer)
print(levels, float(psi.estimateLambda()[0]))
