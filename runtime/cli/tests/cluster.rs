//! A campaign on a Dask cluster of two workers, one of which is killed meanwhile, gives the results
//! of a single process. Needs Python with dask[distributed]: SHEETWORK_PYTHON, the system's, or a
//! virtual environment created in the target folder. Skipped with a message without one.

use std::path::{Path, PathBuf};
use std::process::Command;

#[path = "../../../tests/src/python.rs"]
mod finding;

use finding::python;

fn a_python() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("dask-python");
    python("import distributed", &folder, &["dask[distributed]"])
}

/// Kills a worker and its process when it has begun a shard. Without a nanny the worker is not
/// restarted.
const SCRIPT: &str = r#"
import os, signal, sys, threading, time
sys.path.insert(0, FOLDER)
import bench
from distributed import Client, LocalCluster

if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster, Client(cluster) as client:
        pids = client.run(os.getpid)
        assert len(pids) == 2, pids
        killed = []
        def kill():
            while not killed:
                for worker, tasks in client.processing().items():
                    if tasks:
                        # Stopped first, so that it cannot end its shard meanwhile.
                        os.kill(pids[worker], signal.SIGSTOP)
                        os.kill(pids[worker], signal.SIGKILL)
                        killed.append(worker)
                        return
                time.sleep(0.005)
        killer = threading.Thread(target=kill)
        killer.start()
        written = bench.spread(client, BINARY, "stability", ["--quick"], 6, OUT)
        killer.join()
        assert killed, "no worker was killed"
        assert len(written) == 6 and len(set(written)) == 6, written
    bench.merge(BINARY, "stability", OUT)
    print("the cluster is content")
"#;

#[test]
fn a_map_on_a_cluster_with_a_killed_worker_equals_a_local_one() {
    let Some(python) = a_python() else {
        eprintln!("skipped: no Python with dask[distributed], and none can be installed");
        return;
    };
    let binary = env!("CARGO_BIN_EXE_sheetwork");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cluster-{}", std::process::id()));
    let [spread, alone] = ["spread", "alone"].map(|name| folder.join(name));
    std::fs::create_dir_all(&folder).expect("made");
    let script = folder.join("test.py");
    let tools = Path::new(env!("CARGO_MANIFEST_DIR")).join("../link/python/cluster");
    let text = |path: &Path| format!("{:?}", path.display().to_string());
    let lines = [
        format!("FOLDER = {}", text(&tools)),
        format!("BINARY = {}", text(Path::new(binary))),
        format!("OUT = {}", text(&spread)),
        SCRIPT.to_owned(),
    ];
    std::fs::write(&script, lines.join("\n")).expect("written");
    let ran = Command::new(python).arg(&script).env("PYTHONDONTWRITEBYTECODE", "1").current_dir(&folder).output();
    let ran = ran.expect("starts");
    let (out, err) = (String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr));
    assert!(ran.status.success() && out.contains("the cluster is content"), "{out}{err}");
    let one =
        Command::new(binary).args(["bench", "stability", "--quick", "--out"]).arg(&alone).output().expect("starts");
    assert!(one.status.success(), "{}", String::from_utf8_lossy(&one.stderr));
    let read = |folder: &Path, file: &str| std::fs::read_to_string(folder.join(file)).expect("written");
    assert_eq!(read(&spread, "stability.csv"), read(&alone, "stability.csv"));
    assert_eq!(read(&spread, "stability.md"), read(&alone, "stability.md"));
    assert!(read(&spread, "stability-trimm.svg").contains("<svg"));
    // A missing shard is an error.
    std::fs::remove_file(spread.join("stability-3-of-6.csv")).expect("there");
    std::fs::remove_file(spread.join("stability.csv")).expect("there");
    let mut lacking = Command::new(binary);
    lacking.args(["bench", "stability", "--merge"]).arg(&spread).arg("--out").arg(&alone);
    let lacking = lacking.output().expect("starts");
    let why = String::from_utf8_lossy(&lacking.stderr);
    assert!(lacking.status.code() == Some(2) && why.contains("points are missing"), "{why}");
    std::fs::remove_dir_all(&folder).expect("removed");
}
