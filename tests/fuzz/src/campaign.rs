//! Inputs for all targets in turn, until the time is over.
//!
//! The target that is furthest from its aim is next. A worker that ends without having tried all of its inputs has
//! failed at the one at hand; the next begins behind it.

use std::io::Read;
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::counts::{self, Counts};
use crate::target::{Kind, Target};
use crate::targets::TARGETS;
use crate::worker::{AT, MOST};

/// The time that a slice of the inputs of one target is to take.
const SLICE: Duration = Duration::from_secs(20);
/// A worker that is at one input for so long hangs.
const HANGS: Duration = Duration::from_secs(120);

/// The exit status of cargo-nextest where a test failed.
const TESTS_FAILED: i32 = 100;

/// A target, with its counts so far.
struct Running {
    target: &'static Target,
    program: PathBuf,
    counts: Counts,
    /// The number of inputs of the next slice.
    next: u64,
}

/// Tries inputs for a time; whether none failed, in this run or in one before.
pub(crate) fn run(time: Duration, only: Option<&'static Target>) -> Result<bool, String> {
    let start = Instant::now();
    let targets: Vec<&Target> = only.map_or_else(|| TARGETS.iter().collect(), |only| vec![only]);
    // A copy: building tests may put another file in its place.
    let program =
        counts::all().join(format!("worker-{}{}", std::process::id(), std::env::consts::EXE_SUFFIX));
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let copied = std::fs::create_dir_all(counts::all()).and_then(|()| std::fs::copy(own, &program));
    copied.map_err(|error| format!("{}: {error}", program.display()))?;
    let mut all = Vec::new();
    for target in targets {
        std::fs::create_dir_all(counts::folder(target)).map_err(|error| error.to_string())?;
        all.push(Running { target, program: program.clone(), counts: Counts::of(target)?, next: 100 });
    }
    while start.elapsed() < time {
        let part = |each: &&mut Running| each.counts.inputs as f64 / each.target.aim as f64;
        let Some(next) = all.iter_mut().min_by(|a, b| part(a).total_cmp(&part(b))) else { break };
        next.go_on()?;
        let (name, inputs) = (next.target.name, next.counts.inputs);
        println!("{name}: {inputs} inputs, {} failed", next.counts.failures.len());
        next.counts.keep(next.target)?;
    }
    // What is left over hurts nobody.
    let _ = std::fs::remove_file(&program);
    for each in &all {
        for (number, reason) in &each.counts.failures {
            println!("FAILED: {} {number}: {reason}", each.target.name);
        }
    }
    Ok(all.iter().all(|each| each.counts.failures.is_empty()))
}

/// Whether someone has ended a process: no input raises these signals.
fn is_stopped(status: ExitStatus) -> bool {
    #[cfg(unix)]
    let signal = std::os::unix::process::ExitStatusExt::signal(&status);
    #[cfg(not(unix))]
    let signal: Option<i32> = status.code().and(None);
    // SIGHUP, SIGINT and SIGTERM.
    matches!(signal, Some(1 | 2 | 15))
}

impl Running {
    /// Tries a slice of inputs.
    fn go_on(&mut self) -> Result<(), String> {
        let (start, first) = (Instant::now(), self.counts.inputs);
        let tried = match self.target.kind {
            Kind::Function(_) => self.try_function(self.next)?,
            Kind::Tests { package, filter, cases, most } => self.try_tests(package, filter, [cases, most])?,
        };
        self.counts.inputs = first + tried;
        let rate = tried as f64 / start.elapsed().as_secs_f64().max(0.01);
        self.next = ((rate * SLICE.as_secs_f64()) as u64).clamp(10, 2_000_000);
        Ok(())
    }

    fn try_function(&mut self, count: u64) -> Result<u64, String> {
        let (first, folder) = (self.counts.inputs, counts::folder(self.target));
        let mut worker = Command::new(&self.program)
            .args(["worker", self.target.name, &first.to_string(), &count.to_string()])
            .arg(&folder)
            .current_dir(counts::root())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| error.to_string())?;
        fn reader(stream: Option<impl Read + Send + 'static>) -> JoinHandle<String> {
            let read = |stream| std::io::read_to_string(stream).unwrap_or_default();
            std::thread::spawn(move || stream.map(read).unwrap_or_default())
        }
        let (output, errors) = (reader(worker.stdout.take()), reader(worker.stderr.take()));
        let at = || std::fs::read_to_string(folder.join(AT)).unwrap_or_default();
        let mut last = (Instant::now(), String::new());
        let end = loop {
            if let Some(status) = worker.try_wait().map_err(|error| error.to_string())? {
                break Some(status);
            }
            let now = at();
            if last.1 != now {
                last = (Instant::now(), now);
            } else if last.0.elapsed() > HANGS {
                worker.kill().and_then(|()| worker.wait()).map_err(|error| error.to_string())?;
                break None;
            }
            std::thread::sleep(Duration::from_millis(50));
        };
        for line in output.join().unwrap_or_default().lines() {
            let failed = line.strip_prefix("failed ").and_then(|line| line.split_once(' '));
            if let Some((number, reason)) = failed
                && let Ok(number) = number.parse()
            {
                self.counts.failures.insert(number, reason.to_owned());
            }
        }
        let said = errors.join().unwrap_or_default();
        if end.is_some_and(is_stopped) {
            return Err(format!("the worker of `{}` was stopped from outside", self.target.name));
        }
        match end.map(|status| status.code()) {
            // It has gone through all, with failures or without.
            Some(Some(0 | 1)) => return Ok(count),
            Some(Some(_)) => return Err(format!("the worker of `{}`: {said}", self.target.name)),
            Some(None) | None => {}
        }
        let at = at().trim().parse().unwrap_or(first).clamp(first, first + count - 1);
        let reason = match end {
            Some(status) => format!("ended the process ({status}): out of memory or of stack"),
            None => format!("takes much longer than {} s", MOST.as_secs()),
        };
        self.counts.failures.insert(at, reason);
        Ok(at + 1 - first)
    }

    fn try_tests(&mut self, package: &str, filter: &str, [cases, most]: [u64; 2]) -> Result<u64, String> {
        let filter = format!("package({package}) & ({filter})");
        let (seed, times) = (2 + self.counts.inputs, (self.next / cases).clamp(1, most));
        let mut command = Command::new("cargo");
        // As ordinary tests are built. A test that is skipped for want of a device has tried nothing.
        command
            .args(["nextest", "run", "--no-tests=fail", "--workspace", "--features", "umbragraph/watch"])
            .args(["-E", &filter])
            .current_dir(counts::root())
            .env("UMBRAGRAPH_SEED", seed.to_string())
            .env("UMBRAGRAPH_TIMES", times.to_string())
            .env("UMBRAGRAPH_REQUIRE_GPU", "1");
        let output = command.stdin(Stdio::null()).output().map_err(|error| format!("cargo: {error}"))?;
        match output.status.code() {
            Some(0) => {}
            Some(TESTS_FAILED) => {
                let again = format!(
                    "UMBRAGRAPH_SEED={seed} UMBRAGRAPH_TIMES={times} cargo nextest run --workspace --features umbragraph/watch -E '{filter}' fails"
                );
                self.counts.failures.insert(seed, again);
            }
            // They cannot be built, or there is no nextest.
            _ => return Err(String::from_utf8_lossy(&output.stderr).into_owned()),
        }
        Ok(times * cases)
    }
}
