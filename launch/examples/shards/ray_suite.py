"""Drives a suite of zeronav as a job of Ray, and merges what its shards gave.

    python ray_suite.py --shards 64 --out /shared/suite -- barn --seeds 10 --data /shared/data

Each shard is a task on one core. Ray starts it again elsewhere when its worker or its machine fails.
All machines need the same zeronav and one folder in common; paths must be absolute on a cluster.
Needs `pip install ray`.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import uuid
from pathlib import Path

os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
import ray  # noqa: E402  (reads the variable above)

# Shared memory of a local Ray: tasks return a path. [bytes]
OBJECT_STORE = 80 * 1024 * 1024
# Ends a shard with its worker: it must not go on beside the one that takes its place.
WITH_WORKER = ["setpriv", "--pdeathsig", "TERM"]


def drive(zeronav, suite, shard, out):
    """Drives a shard such as "2/64" in a folder of its own in `out`: the folder of its results."""
    attempt = Path(out) / "shards" / f"{shard.replace('/', '_of_')}-{uuid.uuid4().hex[:8]}"
    command = [zeronav, "suite", *suite, "--shard", shard, "--jobs", "1", "--headless", "--json", "--out", attempt]
    done = subprocess.run(WITH_WORKER + command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"shard {shard}: exit code {done.returncode}: {done.stderr.strip()}")
    return json.loads(done.stdout)["directory"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shards", type=int, required=True, help="parts of the suite; several for each core")
    parser.add_argument("--out", type=Path, required=True, help="folder that all machines have, for results")
    parser.add_argument("--zeronav", default="zeronav", help="the program, on every machine")
    parser.add_argument("--address", help="a cluster that is there, such as auto; without, this machine alone")
    parser.add_argument("--workers", type=int, help="cores of this machine that are used; without --address only")
    parser.add_argument("--retries", type=int, default=5, help="times that a shard is started again")
    parser.add_argument("suite", nargs="+", help="what follows `zeronav suite`, after --")
    arguments = parser.parse_args()
    out = arguments.out.absolute()

    session = None
    if arguments.address:
        ray.init(address=arguments.address)
    else:
        session = tempfile.mkdtemp(prefix="ray")
        ray.init(
            address="local",
            num_cpus=arguments.workers,
            include_dashboard=False,
            object_store_memory=OBJECT_STORE,
            _temp_dir=session,
        )
    try:
        task = ray.remote(num_cpus=1, max_retries=arguments.retries)(drive)
        shards = [f"{index}/{arguments.shards}" for index in range(1, arguments.shards + 1)]
        waiting = [task.remote(arguments.zeronav, arguments.suite, shard, str(out)) for shard in shards]
        folders, errors = [], []
        while waiting:
            [ready], waiting = ray.wait(waiting)
            try:
                folders.append(ray.get(ready))
            except ray.exceptions.RayError as error:
                errors.append(str(error))
            print(f"{len(folders)} of {len(shards)} shards are driven, {len(errors)} failed", file=sys.stderr)
    finally:
        ray.shutdown()
        if session:
            shutil.rmtree(session, ignore_errors=True)
    if errors:
        print("\n".join(errors), "these are driven:", *folders, sep="\n", file=sys.stderr)
        return 1
    merge = [arguments.zeronav, "suite", "merge", *folders, "--json", "--out", out]
    return subprocess.run(merge, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
