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

/// The largest value of an expression, in bytes of text or in elements.
pub(crate) const MAX_VALUE: usize = 1 << 20;
/// The largest text that all expressions of one rendering may write, captured text included.
pub(crate) const MAX_WRITTEN: usize = 16 << 20;
/// The maximum work of checks and filters in one rendering, in elements and pieces of [`PIECE`] bytes.
const MAX_WORK: usize = 4 << 20;
/// The number of bytes of text that cost as much to scan as one element.
const PIECE: usize = 64;
/// The maximum time of one rendering. It bounds what fuel, work and sizes miss: texts of up to 100 MB within one
/// expression. Builds without optimization get more time.
const MAX_TIME: Duration = Duration::from_secs(if cfg!(debug_assertions) { 4 } else { 1 });
/// The function around a value that may have grown.
pub(crate) const FITS: &str = "__fits";
/// The function around an operand of a multiplication.
pub(crate) const FACTOR: &str = "__factor";
/// The function around a value whose elements are visited.
pub(crate) const SEEN: &str = "__seen";
/// The function around a value that is indexed: elements cost one step, characters are counted one by one.
pub(crate) const INDEXED: &str = "__indexed";

/// The engine's own functions, none of which makes a text or a list of lists.
pub(crate) const PLAIN_FUNCTIONS: [&str; 3] = ["range", "namespace", "dict"];
/// Steps of the template engine for one rendering.
const FUEL: u64 = 1_000_000;

thread_local! {
    static DEADLINE: Cell<Option<Instant>> = const { Cell::new(None) };
    static WRITTEN: Cell<usize> = const { Cell::new(0) };
    static WORK: Cell<usize> = const { Cell::new(0) };
    static CALLS: Cell<u32> = const { Cell::new(0) };
    static HAS_CLOCK: Cell<bool> = const { Cell::new(cfg!(not(target_family = "wasm"))) };
}

/// The fuel for one rendering in an environment that holds `longest` bytes of literal text in one piece: captured text
/// does not reach the sink, so that steps times piece has to stay bounded as well.
pub(crate) fn fuel(longest: usize) -> u64 {
    ((1_u64 << 30) / (longest as u64).max(1)).clamp(10_000, FUEL)
}

/// Turns the clock off on this thread: only fuel and sizes end a rendering, however slow the machine is.
#[cfg(test)]
pub(crate) fn without_clock() {
    HAS_CLOCK.set(false);
}

/// Starts the clock and the count of one rendering on this thread.
pub(crate) fn begin() {
    // Browsers have no clock here; fuel and sizes hold there too.
    let clock = HAS_CLOCK.get().then(Instant::now);
    DEADLINE.set(clock.and_then(|now| now.checked_add(MAX_TIME)));
    WRITTEN.set(0);
    WORK.set(0);
}

/// Counts elements and bytes of text that are visited in addition to the engine's own steps.
pub(crate) fn work(elements: usize, bytes: usize) -> Result<(), Error> {
    let total = WORK.get().saturating_add(elements).saturating_add(bytes / PIECE);
    WORK.set(total);
    if total > MAX_WORK {
        return Err(limit("its values and filters go through more than 4,194,304 elements"));
    }
    in_time()
}

/// Counts text that an expression writes.
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

/// The bytes written by expressions and the work since [`begin`].
pub(crate) fn spent() -> (usize, usize) {
    (WRITTEN.get(), WORK.get())
}

/// Whether one rendering may write and do so much.
pub(crate) fn is_within(written: usize, work: usize) -> bool {
    written <= MAX_WRITTEN && work <= MAX_WORK
}

fn in_time() -> Result<(), Error> {
    match DEADLINE.get() {
        Some(deadline) if Instant::now() > deadline => Err(limit("rendering takes longer than a second")),
        _ => Ok(()),
    }
}

/// The error of an exceeded limit; [`is_limit`] recognises it.
pub(crate) fn limit(message: &'static str) -> Error {
    Error::new(ErrorKind::OutOfFuel, message)
}

/// Whether an error reports an exceeded limit.
pub(crate) fn is_limit(error: &Error) -> bool {
    error.kind() == ErrorKind::OutOfFuel
}

/// Returns the value of an expression, or an error if it is larger than [`MAX_VALUE`].
pub(crate) fn grown(value: Value) -> Result<Value, Error> {
    if value.is_number() {
        return Ok(value);
    }
    let (mut budget, mut elements) = (MAX_VALUE, 0);
    let fit = fits(&value, &mut budget, &mut elements, 0);
    work(elements, MAX_VALUE - budget)?;
    if fit { Ok(value) } else { Err(limit("an expression makes a value larger than 1 MiB")) }
}

/// Turns a tuple operand of a multiplication into a list: the engine repeats lists lazily, but copies tuples at once.
pub(crate) fn factor(value: Value) -> Value {
    match value.downcast_object_ref::<Tuple>() {
        Some(tuple) => Value::from(tuple.iter().cloned().collect::<Vec<Value>>()),
        None => value,
    }
}

/// Charges a value whose elements are visited: one unit of work per element, or per piece of a text.
pub(crate) fn seen(value: Value) -> Result<Value, Error> {
    match value.as_str() {
        Some(text) => work(1, text.len())?,
        None => work(value.len().unwrap_or(1), 0)?,
    }
    Ok(value)
}

/// Charges a value that is indexed: the engine counts the characters of a text up to the index.
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
