"""Survey of one STEP file, printed as one line of JSON; see step_survey."""

import json
import sys
from pathlib import Path

from geometry.mesh import MeshError
from geometry.parameters import ParameterError
from geometry.step_file import file_hash, survey_step
from geometry.step_survey import to_plain


def main() -> None:
    """Survey the file of the first argument, whose SHA-256 is the second."""
    path, digest = Path(sys.argv[1]), sys.argv[2]
    try:
        solid = survey_step(path)
        if file_hash(path) != digest:
            raise ParameterError("shape", f"{path.name!r} was written while it was read")
        reply = to_plain(solid)
    except ParameterError as error:
        reply = {"problem": error.problem}
    except MeshError as error:
        reply = {"no_gmsh": str(error)}
    except Exception as error:  # gmsh raises bare Exception; of damaged shapes anything goes wrong
        told = " ".join(str(error).split())[:200] or type(error).__name__
        reply = {
            "problem": f"{path.name!r} has a shape that cannot be measured ({told}): it is "
            "damaged; repair it in CAD and export it again"
        }
    print(f"\n{json.dumps(reply, allow_nan=False)}")


if __name__ == "__main__":
    main()
