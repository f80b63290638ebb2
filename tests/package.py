"""Installs what was built, builds examples/package against that, and runs it; packs it, unpacks that, and asks the program.

package.py CMAKE BUILD_FOLDER SOURCE_FOLDER COMPILER
"""
import os
import pathlib
import shutil
import subprocess
import sys

cmake, build, source, compiler = sys.argv[1:]
folder = pathlib.Path(build).resolve() / "package_test"
shutil.rmtree(folder, ignore_errors=True)
prefix, example = folder / "installed", folder / "example"


def run(*command, **more):
    subprocess.run([str(word) for word in command], check=True, **more)


run(cmake, "--install", build, "--prefix", prefix, stdout=subprocess.DEVNULL)
run(cmake, "-S", pathlib.Path(source) / "examples/package", "-B", example, f"-DCMAKE_PREFIX_PATH={prefix}",
    f"-DCMAKE_CXX_COMPILER={compiler}", "-DCMAKE_BUILD_TYPE=Release", stdout=subprocess.DEVNULL)
run(cmake, "--build", example, stdout=subprocess.DEVNULL)
printed = subprocess.run([example / "falling_sheet"], cwd=folder, check=True, capture_output=True, text=True).stdout
assert printed.startswith("vertex 0 stands at "), printed
assert (folder / "falling_sheet.png").read_bytes().startswith(b"\x89PNG")

# The program stands alone there, and tells of itself.
program = prefix / "bin/render_cloth"
away = {**os.environ, "PATH": "/usr/bin:/bin"}
scenes = subprocess.run([program, "list"], check=True, capture_output=True, text=True, env=away).stdout
assert "drape_sphere" in scenes, scenes
page = (prefix / "share/man/man1/render_cloth.1").read_text()
for word in (".TH RENDER_CLOTH 1", ".SS export", "\\fB\\-\\-format\\fR \\fINAME\\fR", ".SH EXIT STATUS"):
    assert word in page, word
if shutil.which("man"):
    shown = subprocess.run(["man", "--warnings", "-l", "-P", "cat", prefix / "share/man/man1/render_cloth.1"],
                           check=True, capture_output=True, text=True)
    assert "--format NAME" in shown.stdout and not shown.stderr, shown.stderr


def completed(*words):
    script = prefix / "share/bash-completion/completions/render_cloth"
    typed = " ".join(f"'{word}'" for word in words)
    shell = f"PATH={prefix}/bin:$PATH; source {script}; COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; " \
            "_render_cloth; printf '%s\\n' \"${COMPREPLY[@]}\""
    return subprocess.run(["bash", "-c", shell], check=True, capture_output=True, text=True).stdout.split()


assert completed("render_cloth", "sim") == ["simulate"]
assert "--frames" in completed("render_cloth", "export", "--fr")
assert completed("render_cloth", "export", "--format", "us") == ["usda"]
assert completed("render_cloth", "--scene", "drape") == ["drape_sphere"]
assert "schema" in completed("render_cloth", "list", "")

# As packages, where Debian's tool is there that finds what a program depends on.
if shutil.which("dpkg-shlibdeps"):
    packages = folder / "packages"
    run(pathlib.Path(cmake).parent / "cpack" if pathlib.Path(cmake).parent.name else "cpack", "--config",
        pathlib.Path(build).resolve() / "CPackConfig.cmake", "-B", packages, stdout=subprocess.DEVNULL)
    run("dpkg-deb", "-x", next(packages.glob("render-cloth_*.deb")), folder / "root")
    run("dpkg-deb", "-x", next(packages.glob("librender-cloth-dev_*.deb")), folder / "root")
    assert next(packages.glob("*.tar.gz")).stat().st_size > 1000000
    unpacked = subprocess.run([folder / "root/usr/bin/render_cloth", "list"], check=True, capture_output=True, text=True)
    assert unpacked.stdout == scenes
    assert (folder / "root/usr/include/render_cloth/sim/simulation.h").exists()
    needed = subprocess.run(["dpkg-deb", "-f", next(packages.glob("render-cloth_*.deb")), "Depends"], check=True,
                            capture_output=True, text=True).stdout
    assert "libassimp5" in needed and "libtbb12" in needed, needed
shutil.rmtree(folder)
