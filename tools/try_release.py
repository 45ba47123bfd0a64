"""Try an installed kinolab as its users would: python tools/try_release.py [FOLDER].

Plans, checks, executes, writes the course, makes a study and reads a robot, with nothing but what
is installed. Ends with an error at the first command that does not end as it should.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ARM = """<robot name="lever">
  <link name="base"/>
  <link name="arm">
    <inertial>
      <origin xyz="0 0 -0.25"/>
      <mass value="1.0"/>
      <inertia ixx="0.02" iyy="0.02" izz="0.002" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision><origin xyz="0 0 -0.25"/><geometry><box size="0.05 0.05 0.5"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="base"/><child link="arm"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="5" effort="10"/>
  </joint>
</robot>
"""
SCENARIO = """schema = 1
title = "A lever is raised"
[system]
file = "lever.urdf"
[start]
hinge = 0.0
[goal]
hinge = 1.5
tolerance = 0.1
[planner]
name = "auto"
time_limit = 30.0
"""
STUDY = """schema = 1
title = "Two seeds"
improve = false
[[case]]
scenarios = ["pendulum_swingup"]
seeds = 2
"""
COMMANDS = (
    ("plan", "rolling_disk_maze"),
    ("plan", "check", "runs/rolling_disk_maze"),
    ("plan", "execute", "runs/rolling_disk_maze", "--runs", "4"),
    ("plan", "course", "course"),
    ("plan", "bench", "study.toml", "--out", "study"),
    ("plan", "lever.toml", "--no-animation"),
)


def main() -> None:
    """Run all commands in a folder of their own."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp()).resolve()
    files = {"lever.urdf": ARM, "lever.toml": SCENARIO, "study.toml": STUDY}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    search_path = os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", "")))
    for command in COMMANDS:
        print("$", *command, flush=True)
        subprocess.run(command, cwd=folder, env=os.environ | {"PATH": search_path}, check=True)
    for made in (
        "runs/rolling_disk_maze/animation.gif",
        "course",
        "study",
        "runs/lever/report.json",
    ):
        assert (folder / made).exists(), made


if __name__ == "__main__":
    main()
