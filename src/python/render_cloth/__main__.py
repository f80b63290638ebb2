"""python -m render_cloth is the program render_cloth."""
import os
import pathlib
import shutil
import sys

here = pathlib.Path(__file__).resolve()
beside = [parent / "bin" / "render_cloth" for parent in here.parents] + [parent / "render_cloth" for parent in here.parents]
program = next((str(p) for p in beside if p.is_file() and os.access(p, os.X_OK)), shutil.which("render_cloth"))
if program is None:
    sys.exit("render_cloth: the program is neither beside this module nor on PATH")
os.execv(program, [program, *sys.argv[1:]])
