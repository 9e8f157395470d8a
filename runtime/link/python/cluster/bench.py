"""Distributes the shards of a `sheetwork bench` campaign over a Dask cluster and merges them.

    python runtime/link/python/cluster/bench.py --local 4 --shards 32 stability
    python runtime/link/python/cluster/bench.py --scheduler tcp://head:8786 --shards 200 \\
        --binary /opt/sheetwork stability

The binary is on every worker, at the same path. Dask assigns shards to workers and repeats those
of failed workers. Needs `dask[distributed]`.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

try:
    from distributed import Client, LocalCluster, as_completed
except ImportError:
    print('this wants Dask, which is not installed: pip install "dask[distributed]"', file=sys.stderr)
    sys.exit(2)


def run_shard(binary, campaign, extra, index, count):
    """Runs shard `index` of `count` on the worker; returns the name and text of its file."""
    with tempfile.TemporaryDirectory() as folder:
        command = [binary, "bench", campaign, *extra, "--shard", f"{index}/{count}", "--out", folder]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"shard {index}/{count}: {done.stderr.strip() or done.returncode}")
        (file,) = pathlib.Path(folder).glob("*.csv")
        return file.name, file.read_text()


def spread(client, binary, campaign, extra, shards, out, retries=3):
    """Runs all shards on the cluster of `client` and writes their files to the folder `out`, as
    they arrive.
    """
    out = pathlib.Path(out)
    out.mkdir(parents=True, exist_ok=True)
    # The result depends on the binary in addition to the arguments, so it must not be cached.
    futures = client.map(
        lambda index: run_shard(binary, campaign, extra, index, shards),
        range(1, shards + 1),
        retries=retries,
        pure=False,
    )
    written = []
    for future, (name, text) in as_completed(futures, with_results=True):
        (out / name).write_text(text)
        written.append(name)
        print(f"{len(written)} of {shards}: {name}", file=sys.stderr)
    return written


def merge(binary, campaign, out):
    """Creates table, CSV and pictures from the files in `out`."""
    subprocess.run([binary, "bench", campaign, "--merge", str(out), "--out", str(out)], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--scheduler", help="address of a running Dask scheduler, such as tcp://head:8786")
    where.add_argument("--local", type=int, metavar="N", help="a cluster of N workers on this machine")
    parser.add_argument("--shards", type=int, default=32, help="parts of the campaign (default 32)")
    parser.add_argument("--retries", type=int, default=3, help="how often a shard that fails is run again (default 3)")
    parser.add_argument("--binary", default="target/release/sheetwork", help="where the workers have it")
    parser.add_argument("--out", default="sheetwork-out/cluster", help="folder for the files")
    parser.add_argument("campaign", choices=["stability", "pareto"])
    parser.add_argument("extra", nargs="*", help="further flags of the campaign, after --")
    options = parser.parse_args()
    if options.shards < 1:
        parser.error("--shards is at least 1")
    if options.local is not None:
        if options.local < 1:
            parser.error("--local is at least 1")
        binary = str(pathlib.Path(options.binary).resolve())
        cluster = LocalCluster(n_workers=options.local, threads_per_worker=1, dashboard_address=None)
    else:
        binary, cluster = options.binary, options.scheduler
    with Client(cluster) as client:
        spread(client, binary, options.campaign, options.extra, options.shards, options.out, options.retries)
    merge(binary, options.campaign, options.out)


if __name__ == "__main__":
    main()
