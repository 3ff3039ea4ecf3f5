//! The cost of `umbragraph permutations` for each file of `pipelines/`, one process each.
//!
//! The command runs three times: without a cache, with a new cache, and with that cache again. The table shows the CPU
//! time and the memory of the first run, and the wall time of the third.
//!
//! CPU time is the sum over all threads, and memory the largest resident set. Both are read from `/proc` every 10 ms;
//! their cells are empty on systems without it. Lines `ratio NAME VALUE` divide by the aims: 8 s of CPU time for all
//! pipelines, 400 MB for the largest, and 0.1 s for all third runs.
//!
//! `cargo bench -p umbragraph-cli --no-default-features --bench proofs`

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[path = "measure.rs"]
mod measure;

/// The time and the memory that a process took.
#[derive(Clone, Copy, Default)]
struct Run {
    wall: Duration,
    /// The CPU time in seconds; `None` if it could not be read.
    cpu: Option<f64>,
    /// The largest resident set, in megabytes; `None` if it could not be read.
    memory: Option<u64>,
}

fn main() {
    let cache = std::env::temp_dir().join(format!("umbragraph-proofs-{}", std::process::id()));
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let entries = std::fs::read_dir(root.join("pipelines")).expect("the pipelines of the project");
    let mut pipelines: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    pipelines.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
    pipelines.sort();
    let mut rows = Vec::new();
    let (mut all, mut most): (Option<f64>, Option<u64>) = (Some(0.0), None);
    let mut again = Duration::ZERO;
    for path in &pipelines {
        let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let cached = |with: &[&str]| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
            command.arg("permutations").arg(path).args(with);
            measured(&mut command)
        };
        let (cold, said) = cached(&["--no-cache", "--verbose"]);
        let folder = cache.display().to_string();
        cached(&["--cache", &folder]);
        let (warm, _) = cached(&["--cache", &folder]);
        again += warm.wall;
        all = all.zip(cold.cpu).map(|(all, cpu)| all + cpu);
        most = most.max(cold.memory);
        let counts = counts(&said);
        let [texts, parsed] = counts.map(|count| count.map_or_else(String::new, |count| count.to_string()));
        rows.push([
            format!("`{name}`"),
            texts,
            parsed,
            cold.cpu.map_or_else(String::new, |cpu| format!("{cpu:.1} s")),
            cold.memory.map_or_else(String::new, |memory| format!("{memory} MB")),
            format!("{:.2} s", warm.wall.as_secs_f64()),
        ]);
    }
    let _ = std::fs::remove_dir_all(&cache);
    let heads = ["pipeline", "texts of WGSL", "parsed by naga", "CPU time", "memory", "again, all known"];
    measure::table(heads, &rows);
    if let (Some(all), Some(most)) = (all, most) {
        println!("ratio proofs/cpu_to_8s {:.3}", all / 8.0);
        println!("ratio proofs/memory_to_400MB {:.3}", most as f64 / 400.0);
    }
    println!("ratio proofs/again_to_100ms {:.3}", again.as_secs_f64() / 0.1);
}

/// Runs a command to its end. Returns its time and memory, and its output.
fn measured(command: &mut Command) -> (Run, String) {
    let start = Instant::now();
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the command");
    let id = child.id();
    let watch = std::thread::spawn(move || {
        let mut run = Run::default();
        while let Some((cpu, memory)) = now(id) {
            run.cpu = Some(cpu);
            run.memory = run.memory.max(Some(memory));
            std::thread::sleep(Duration::from_millis(10));
        }
        run
    });
    let output = child.wait_with_output().expect("an output");
    let wall = start.elapsed();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    (Run { wall, ..watch.join().unwrap_or_default() }, said)
}

/// Returns the CPU time of a process in seconds and its largest resident set in megabytes; `None` if it has ended.
fn now(id: u32) -> Option<(f64, u64)> {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    // The second field is a name in parentheses, the fourteenth and fifteenth are hundredths of a second.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11).map(str::parse::<f64>);
    let cpu = (fields.next()?.ok()? + fields.next()?.ok()?) / 100.0;
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"))?;
    Some((cpu, peak.trim().parse::<u64>().ok()? / 1000))
}

/// Parses the numbers of distinct shader sources and of those that naga parsed, from the last matching line of an
/// output.
fn counts(said: &str) -> [Option<u64>; 2] {
    let line = said
        .lines()
        .rev()
        .find_map(|line| line.split_once(" covered by ")?.1.split_once(" distinct texts; "));
    let number = |text: &str| text.split_whitespace().next()?.replace(',', "").parse().ok();
    match line {
        Some((texts, rest)) => [number(texts), number(rest)],
        None => [None; 2],
    }
}
