#!/usr/bin/env python3
"""Runs a campaign on Dask: one task for each trial, and the tables once all are there.

    cargo build --release && pip install distributed
    python tools/bench_dask.py --suite heats-tables --out bench --workers 2          # workers on this machine
    python tools/bench_dask.py --suite heats-tables --out /shared/bench --scheduler tcp://head:8786

Every worker needs the program and the folder at the same paths. A task is `seekplan bench --shard I/N --resume`, which leaves a
whole result or none and does nothing where one is there: Dask may repeat a task, lose a worker or run one twice. Memory of a trial
is below 1 GiB. The same without Dask, by GNU parallel on one machine:

    N=$(seekplan bench --suite heats-tables --list | wc -l)
    seq $N | parallel --joblog jobs.log --resume seekplan bench --suite heats-tables --out bench --shard {}/$N --resume --quiet
    seekplan bench --suite heats-tables --out bench --collect

and by Slurm as an array of 20 tasks that share the trials (bench.sbatch; run it again for what is missing):

    #!/bin/bash
    #SBATCH --array=1-20 --cpus-per-task=1 --mem=1G --time=12:00:00
    srun seekplan bench --suite heats-tables --out /shared/bench --shard $SLURM_ARRAY_TASK_ID/20 --resume --quiet
"""
import argparse
import subprocess
import sys
from pathlib import Path

from distributed import Client, LocalCluster, as_completed

PROGRAM = Path(__file__).resolve().parent.parent / "target/release/seekplan"


def trial(command, part, parts):
    """Runs one trial; what the program says on failure becomes the task's error."""
    run = subprocess.run([*command, "--shard", f"{part}/{parts}", "--resume", "--quiet"], capture_output=True, text=True)
    if run.returncode != 0:
        raise RuntimeError(f"trial {part} of {parts}: {run.stderr.strip()}")
    return part


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--suite", default="heats-tables")
    parser.add_argument("--out", default="bench")
    parser.add_argument("--trials", type=int, help="seeds of each experiment")
    parser.add_argument("--reports", action="store_true", help="leave a page of each trial")
    parser.add_argument("--program", default=str(PROGRAM))
    parser.add_argument("--scheduler", help="address of a running scheduler")
    parser.add_argument("--workers", type=int, default=2, help="workers on this machine, where no scheduler is named")
    args = parser.parse_args()
    command = [args.program, "bench", "--suite", args.suite, "--out", args.out]
    command += [] if args.trials is None else ["--trials", str(args.trials)]
    names = subprocess.run([*command, "--list"], check=True, capture_output=True, text=True).stdout.split()
    local = None if args.scheduler else LocalCluster(n_workers=args.workers, threads_per_worker=1, dashboard_address=None)
    with Client(args.scheduler or local) as client:
        parts = range(1, len(names) + 1)
        each = [*command, "--reports"] if args.reports else command
        tasks = client.map(trial, [each] * len(names), parts, parts=len(names), pure=False, retries=2)
        for done, task in enumerate(as_completed(tasks), 1):
            print(f"[{done}/{len(names)}] {names[task.result() - 1]}", file=sys.stderr)
    sys.exit(subprocess.run([*command, "--collect"]).returncode)


if __name__ == "__main__":
    main()
