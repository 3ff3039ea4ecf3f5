//! Inputs of one target, tried in this process.
//!
//! The number of the input at hand stands in a file, so that whoever started the process knows which one has ended it.

use std::cell::{Cell, RefCell};
use std::io::{Seek as _, Write as _};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::time::Duration;

use umbragraph_test_support::random::Random;

use crate::counts;
use crate::mutation::Choices;
use crate::target::{Kind, Target};

/// The processor time that an input may take. Templates may take four seconds in a debug build, which is slow.
pub(crate) const MOST: Duration = Duration::from_secs(if cfg!(debug_assertions) { 5 } else { 1 });

/// The bytes of memory that the process may reserve.
#[cfg(target_os = "linux")]
const MEMORY: u64 = 1 << 30;

/// The maximum number of bytes of choices for an input.
const BYTES: usize = 256;

/// The name of the file with the number at hand.
pub(crate) const AT: &str = "at";

thread_local! {
    static SHOWN: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static SHOWS: Cell<bool> = const { Cell::new(false) };
}

/// Takes a note of the input that is about to be tried, for whoever looks into a failure.
pub(crate) fn note(input: impl Into<Vec<u8>>) {
    let input = input.into();
    if SHOWS.get() {
        // Before it is tried: it may end the process.
        let _ = std::io::stdout().write_all(&input).and_then(|()| std::io::stdout().flush());
    }
    SHOWN.set(input);
}

/// The bytes of the choices of an input: short ones and long ones.
fn bytes(target: &Target, number: u64) -> Vec<u8> {
    let name = blake3::hash(target.name.as_bytes());
    let first = name.as_bytes().first_chunk().copied().map_or(0, u64::from_le_bytes);
    let mut random = Random(first ^ number.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let length = 8 + random.below(BYTES);
    (0..length.div_ceil(8)).flat_map(|_| random.next().to_le_bytes()).collect()
}

fn function(target: &Target) -> Result<fn(&mut Choices<'_>), String> {
    match target.kind {
        Kind::Function(function) => Ok(function),
        Kind::Tests { package, filter, .. } => {
            Err(format!("`{}` are tests: cargo nextest run -p {package} -E '{filter}'", target.name))
        }
    }
}

/// The processor time of all threads so far: templates are rendered and proven on others.
pub(crate) fn processor_time() -> Duration {
    #[cfg(unix)]
    let time = {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
    };
    #[cfg(not(unix))]
    let time = Duration::ZERO;
    time
}

#[cfg(target_os = "linux")]
fn limit_memory() {
    let limit = rustix::process::Rlimit { current: Some(MEMORY), maximum: Some(MEMORY) };
    // Without the limit there is only less to be found.
    let _ = rustix::process::setrlimit(rustix::process::Resource::As, limit);
}

/// Tries inputs from a number on, and prints `failed NUMBER REASON` for each that fails.
pub(crate) fn run(target: &Target, first: u64, count: u64, folder: &Path) -> Result<bool, String> {
    let function = function(target)?;
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut at = std::fs::File::create(folder.join(AT)).map_err(failed)?;
    #[cfg(target_os = "linux")]
    limit_memory();
    static SAID: Mutex<String> = Mutex::new(String::new());
    std::panic::set_hook(Box::new(|panic| {
        let said = panic.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        *SAID.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = said;
    }));
    let mut is_fine = true;
    for number in first..first.saturating_add(count) {
        at.rewind().and_then(|()| write!(at, "{number:>20}")).map_err(failed)?;
        let bytes = bytes(target, number);
        let take = || {
            let before = processor_time();
            let end = catch_unwind(AssertUnwindSafe(|| function(&mut Choices::new(&bytes))));
            (end.is_ok(), processor_time().saturating_sub(before))
        };
        let (mut fine, mut time) = take();
        if fine && time > MOST {
            // Once more: what is read for the first time takes longer.
            (fine, time) = take();
        }
        let reason = if !fine {
            std::mem::take(&mut *SAID.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
        } else if time > MOST {
            format!("took {:.1} s", time.as_secs_f64())
        } else {
            continue;
        };
        is_fine = false;
        println!("failed {number} {reason}");
        let kept = SHOWN.with_borrow(|shown| std::fs::write(folder.join(number.to_string()), shown));
        kept.map_err(failed)?;
    }
    Ok(is_fine)
}

/// Prints an input, and tries it.
pub(crate) fn show(target: &Target, number: u64) -> Result<bool, String> {
    let function = function(target)?;
    std::env::set_current_dir(counts::root()).map_err(|error| error.to_string())?;
    #[cfg(target_os = "linux")]
    limit_memory();
    SHOWS.set(true);
    let bytes = bytes(target, number);
    Ok(catch_unwind(AssertUnwindSafe(|| function(&mut Choices::new(&bytes)))).is_ok())
}
