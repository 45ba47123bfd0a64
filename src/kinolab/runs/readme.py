"""``README.txt`` of a run's folder: what somebody should know who has nothing but the folder."""

from __future__ import annotations

from kinolab.problem import PlanningTask
from kinolab.solve import PlanResult

README = "README.txt"
TEXT = """\
{title}
{status}: {message}

trajectory.csv   the motion, a row per step; trajectory.npz has the same for NumPy
                 SI units and rad; angles are not wrapped; quaternions are x, y, z, w;
                 inputs are held from their row to the next, so the last row has none
                 (there is none if nothing was found)
report.json      how it was found, every check of it, and what went wrong if something did
certificate.json what was proved of the motion, what was not, and of which files
scenario.toml    what was asked for, with every default; assets/ has what belongs to it
scene.html       the motion in three dimensions, if pictures were drawn: open it in a browser

In this folder, "plan check ." verifies it all from these files alone, "plan view ." shows it, and
"plan help files" explains every file, column and number.
"""


def readme_of(problem: PlanningTask, plan: PlanResult) -> str:
    """Return the text of ``README.txt``.

    Args:
        problem: What was planned.
        plan: What came of it.
    """
    title = " ".join(problem.scenario.title.split())
    return TEXT.format(title=title, status=plan.status, message=plan.message)
