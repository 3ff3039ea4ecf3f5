//! Guards against templates that grow without end.
//!
//! The template engine counts its steps (fuel), and the sink counts the bytes that reach it. Neither notices a value
//! that doubles inside a variable: thirty rounds of `set s = s ~ s` are few steps and a gigabyte. Nor do they notice
//! how long one step takes on a long value. So [functions](super::tree) wrap the expressions that make large values.
//! They check the results, and count the work of checks and filters ([`work`]). They stand inside tags and contain no
//! line break, so that they change no output; [`Prepared::original`](super::tree::Prepared::original) maps offsets
//! back.

use std::cell::Cell;
use std::time::{Duration, Instant};

use minijinja::value::{Tuple, Value, ValueKind};
use minijinja::{Error, ErrorKind};

/// The maximum size of a template value: the bytes of its strings, plus one for each other element.
pub(crate) const MAX_VALUE: usize = 1 << 20;
/// The maximum number of bytes that all expressions of one rendering write, including captured output.
pub(crate) const MAX_WRITTEN: usize = 16 << 20;
/// The maximum number of elements that checks and filters visit in one rendering. [`PIECE`] bytes of a string count as
/// one element.
const MAX_WORK: usize = 4 << 20;
/// The number of string bytes that count as one element of work.
const PIECE: usize = 64;
/// The maximum time of one rendering. It limits operations that fuel, work and sizes do not cover, such as strings of
/// up to 100 MB within one expression. Builds without optimization get more time.
const MAX_TIME: Duration = Duration::from_secs(if cfg!(debug_assertions) { 4 } else { 1 });
/// The name of the template function that checks the size of a value. `tree::prepare` inserts its calls.
pub(crate) const FITS: &str = "__fits";
/// The name of the template function that turns a tuple operand of a multiplication into a list.
pub(crate) const FACTOR: &str = "__factor";
/// The name of the template function that counts the work of visiting a value's elements.
pub(crate) const SEEN: &str = "__seen";
/// The name of the template function that counts the work of indexing a string.
pub(crate) const INDEXED: &str = "__indexed";

/// The functions of minijinja that return neither a string nor a nested list, so that their results need no size check.
pub(crate) const PLAIN_FUNCTIONS: [&str; 3] = ["range", "namespace", "dict"];
/// The maximum number of minijinja's execution steps ("fuel") for one rendering.
const FUEL: u64 = 1_000_000;

thread_local! {
    static DEADLINE: Cell<Option<Instant>> = const { Cell::new(None) };
    static WRITTEN: Cell<usize> = const { Cell::new(0) };
    static WORK: Cell<usize> = const { Cell::new(0) };
    static CALLS: Cell<u32> = const { Cell::new(0) };
    static HAS_CLOCK: Cell<bool> = const { Cell::new(cfg!(not(target_family = "wasm"))) };
}

/// Returns the fuel (in minijinja's execution steps) for one rendering. A longer literal (`longest`, in bytes) means
/// less fuel, which limits the size of captured output.
pub(crate) fn fuel(longest: usize) -> u64 {
    ((1_u64 << 30) / (longest as u64).max(1)).clamp(10_000, FUEL)
}

/// Disables the time limit on this thread; fuel and sizes still limit a rendering.
#[cfg(test)]
pub(crate) fn without_clock() {
    HAS_CLOCK.set(false);
}

/// Starts the clock and resets the counters for one rendering on this thread.
pub(crate) fn begin() {
    // Browsers have no clock here; fuel and sizes hold there too.
    let clock = HAS_CLOCK.get().then(Instant::now);
    DEADLINE.set(clock.and_then(|now| now.checked_add(MAX_TIME)));
    WRITTEN.set(0);
    WORK.set(0);
}

/// Counts visited elements and string bytes as work; returns an error above [`MAX_WORK`].
pub(crate) fn work(elements: usize, bytes: usize) -> Result<(), Error> {
    let total = WORK.get().saturating_add(elements).saturating_add(bytes / PIECE);
    WORK.set(total);
    if total > MAX_WORK {
        return Err(limit("its values and filters go through more than 4,194,304 elements"));
    }
    in_time()
}

/// Counts bytes that an expression writes; returns an error above [`MAX_WRITTEN`].
pub(crate) fn written(bytes: usize) -> Result<(), Error> {
    let total = WRITTEN.get().saturating_add(bytes);
    WRITTEN.set(total);
    if total > MAX_WRITTEN {
        return Err(limit("its expressions write more than 16 MiB"));
    }
    // The clock takes longer than most of what is written.
    let calls = CALLS.get().wrapping_add(1);
    CALLS.set(calls);
    if calls.is_multiple_of(16) { in_time() } else { Ok(()) }
}

/// Returns the bytes that expressions have written and the elements that checks and filters have visited, since
/// [`begin`].
pub(crate) fn spent() -> (usize, usize) {
    (WRITTEN.get(), WORK.get())
}

/// Returns `true` if the bytes written and the elements visited are within the limits of one rendering.
pub(crate) fn is_within(written: usize, work: usize) -> bool {
    written <= MAX_WRITTEN && work <= MAX_WORK
}

fn in_time() -> Result<(), Error> {
    match DEADLINE.get() {
        Some(deadline) if Instant::now() > deadline => Err(limit("rendering takes longer than a second")),
        _ => Ok(()),
    }
}

/// Creates the error of an exceeded limit, which [`is_limit`] recognizes.
pub(crate) fn limit(message: &'static str) -> Error {
    Error::new(ErrorKind::OutOfFuel, message)
}

/// Returns `true` if the error reports an exceeded limit.
pub(crate) fn is_limit(error: &Error) -> bool {
    error.kind() == ErrorKind::OutOfFuel
}

/// Returns the value, or an error if it is larger than [`MAX_VALUE`].
pub(crate) fn grown(value: Value) -> Result<Value, Error> {
    if value.is_number() {
        return Ok(value);
    }
    let (mut budget, mut elements) = (MAX_VALUE, 0);
    let fit = fits(&value, &mut budget, &mut elements, 0);
    work(elements, MAX_VALUE - budget)?;
    if fit { Ok(value) } else { Err(limit("an expression makes a value larger than 1 MiB")) }
}

/// Converts a tuple operand of a multiplication to a list, since minijinja repeats lists lazily but copies tuples.
pub(crate) fn factor(value: Value) -> Value {
    match value.downcast_object_ref::<Tuple>() {
        Some(tuple) => Value::from(tuple.iter().cloned().collect::<Vec<Value>>()),
        None => value,
    }
}

/// Returns a value unchanged and counts the work of visiting it: one per element, or one per [`PIECE`] bytes of a
/// string. Returns an error above [`MAX_WORK`].
pub(crate) fn seen(value: Value) -> Result<Value, Error> {
    match value.as_str() {
        Some(text) => work(1, text.len())?,
        None => work(value.len().unwrap_or(1), 0)?,
    }
    Ok(value)
}

/// Returns a value unchanged and counts the work of indexing it, since minijinja walks a string's characters up to the
/// index. Returns an error above [`MAX_WORK`].
pub(crate) fn indexed(value: Value) -> Result<Value, Error> {
    if let Some(text) = value.as_str() {
        work(1, text.len())?;
    }
    Ok(value)
}

fn fits(value: &Value, budget: &mut usize, elements: &mut usize, depth: usize) -> bool {
    *elements += 1;
    let size = match value.as_str() {
        Some(text) => text.len(),
        None => 1,
    };
    match budget.checked_sub(size) {
        Some(rest) => *budget = rest,
        None => return false,
    }
    match value.kind() {
        // An iterable (a range, a concatenation) is lazy: its length is bounded, its elements are looked at one by one.
        ValueKind::Iterable | ValueKind::Seq | ValueKind::Map if depth > 64 => false,
        ValueKind::Iterable | ValueKind::Seq => match value.len() {
            Some(length) if length > MAX_VALUE => false,
            _ => value
                .try_iter()
                .is_ok_and(|mut items| items.all(|item| fits(&item, budget, elements, depth + 1))),
        },
        ValueKind::Map => value.try_iter().is_ok_and(|mut keys| {
            keys.all(|key| value.get_item(&key).is_ok_and(|item| fits(&item, budget, elements, depth + 1)))
        }),
        _ => true,
    }
}
