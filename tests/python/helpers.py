"""What the tests of the Python module share."""

import json
import os
import subprocess

SOURCE = os.environ["ELASTIN_SOURCE_DIR"]
TABLE_1 = [f"{SOURCE}/scenes/tension/table1-{letter}.yaml" for letter in "abcd"]
CUBE = f"{SOURCE}/scenes/tension/cube-27-face.yaml"


def command(*arguments):
    return subprocess.run([os.environ["ELASTIN_COMMAND"], *arguments], capture_output=True, text=True, check=False)


def runs_of_command(*arguments):
    """What the command writes with --json."""
    return json.loads(command(*arguments, "--json", "-").stdout)["runs"]


def said_by_command(*arguments):
    """The message of its error."""
    ended = command(*arguments)
    assert ended.returncode == 2, ended
    return ended.stderr.strip().removeprefix("elastin: ")
