//! Tasks that are made and done at the same time.
//!
//! One thread, the lead, makes tasks; the others do them. When so many wait that memory would fill, the lead helps until
//! half of them are done, and after the last it helps to the end, so that no thread idles while there is work. Many are
//! made and then many done, since either goes faster in its own caches and heap. The heaviest task that waits comes
//! first: what is left at the end is light, and the threads end together.
//!
//! A task has the index of its making, and its answer stands there: what comes out depends neither on the number of
//! threads nor on their order.

use std::collections::BinaryHeap;
use std::panic::resume_unwind;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crate::wgsl;

/// The most threads that are worth their stacks.
const MAXIMUM_THREADS: usize = 256;

/// Tasks on their way.
pub(super) struct Pool<'w, T, A> {
    state: Mutex<State<T, A>>,
    changed: Condvar,
    work: &'w (dyn Fn(T) -> A + Sync),
    progress: &'w (dyn Fn(usize, usize) + Sync),
}

struct State<T, A> {
    waiting: BinaryHeap<Waiting<T>>,
    waiting_weight: usize,
    /// The most weight that waits.
    allowed_weight: usize,
    answers: Vec<Option<A>>,
    done: usize,
    closed: bool,
}

struct Waiting<T> {
    weight: usize,
    index: usize,
    task: T,
}

impl<T> Waiting<T> {
    /// Heavy before light, early before late.
    fn rank(&self) -> (usize, std::cmp::Reverse<usize>) {
        (self.weight, std::cmp::Reverse(self.index))
    }
}

impl<T> PartialEq for Waiting<T> {
    fn eq(&self, other: &Self) -> bool {
        self.rank() == other.rank()
    }
}

impl<T> Eq for Waiting<T> {}

impl<T> PartialOrd for Waiting<T> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> Ord for Waiting<T> {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.rank().cmp(&other.rank())
    }
}

/// Closes the pool however its lead ends, so that no thread waits for ever.
struct Closing<'p, 'w, T, A>(&'p Pool<'w, T, A>);

impl<T, A> Drop for Closing<'_, '_, T, A> {
    fn drop(&mut self) {
        self.0.lock().closed = true;
        self.0.changed.notify_all();
    }
}

impl<'w, T: Send, A: Send> Pool<'w, T, A> {
    /// Makes tasks by `make` and does each by `work`, on `threads` threads with stacks that are deep enough for naga; the
    /// answers are in the order in which the tasks were made. At most about `allowed_weight` waits at a time.
    /// A panic of any thread goes on in the caller.
    /// `progress` hears of the tasks done and those made, from any thread.
    pub(super) fn run<R: Send + Default>(
        threads: usize,
        allowed_weight: usize,
        work: &'w (dyn Fn(T) -> A + Sync),
        progress: &'w (dyn Fn(usize, usize) + Sync),
        make: impl FnOnce(&Self) -> R + Send,
    ) -> (R, Vec<A>) {
        let state = State {
            waiting: BinaryHeap::new(),
            waiting_weight: 0,
            allowed_weight,
            answers: Vec::new(),
            done: 0,
            closed: false,
        };
        let pool = Self { state: Mutex::new(state), changed: Condvar::new(), work, progress };
        let make = Mutex::new(Some(make));
        let lead = || {
            let make = make.lock().unwrap_or_else(PoisonError::into_inner).take();
            make.map(|make| pool.lead(make)).unwrap_or_default()
        };
        let made = if cfg!(target_family = "wasm") {
            lead()
        } else {
            std::thread::scope(|scope| {
                // A thread that panics before it leads would leave the others waiting.
                let closing = Closing(&pool);
                let start = || std::thread::Builder::new().stack_size(wgsl::STACK_BYTES);
                let helpers: Vec<_> = (1..threads.clamp(1, MAXIMUM_THREADS))
                    .filter_map(|_| start().spawn_scoped(scope, || pool.help()).ok())
                    .collect();
                let made = match start().spawn_scoped(scope, lead) {
                    Ok(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
                    Err(_) => lead(),
                };
                drop(closing);
                // The scope would end them with a message of its own.
                helpers
                    .into_iter()
                    .for_each(|helper| helper.join().unwrap_or_else(|panic| resume_unwind(panic)));
                made
            })
        };
        let answers = pool.state.into_inner().unwrap_or_else(PoisonError::into_inner).answers;
        (made, answers.into_iter().flatten().collect())
    }

    /// Adds a task; the number of tasks before it.
    pub(super) fn add(&self, weight: usize, task: T) -> usize {
        let mut state = self.lock();
        let index = state.answers.len();
        state.answers.push(None);
        state.waiting.push(Waiting { weight, index, task });
        state.waiting_weight += weight;
        self.changed.notify_one();
        if state.waiting_weight > state.allowed_weight {
            while state.waiting_weight > state.allowed_weight / 2
                && let Some(waiting) = state.take()
            {
                drop(state);
                self.work_on(waiting);
                state = self.lock();
            }
        }
        index
    }

    fn lead<R>(&self, make: impl FnOnce(&Self) -> R) -> R {
        let closing = Closing(self);
        let made = make(self);
        drop(closing);
        self.help();
        made
    }

    /// Does tasks until none is left and none will come.
    fn help(&self) {
        let mut state = self.lock();
        loop {
            if let Some(waiting) = state.take() {
                drop(state);
                self.work_on(waiting);
                state = self.lock();
            } else if state.closed {
                return;
            } else {
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
        }
    }

    fn work_on(&self, waiting: Waiting<T>) {
        let answer = (self.work)(waiting.task);
        let mut state = self.lock();
        if let Some(place) = state.answers.get_mut(waiting.index) {
            *place = Some(answer);
        }
        state.done += 1;
        let (done, all) = (state.done, state.answers.len());
        drop(state);
        (self.progress)(done, all);
    }
}

impl<T, A> Pool<'_, T, A> {
    fn lock(&self) -> MutexGuard<'_, State<T, A>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T, A> State<T, A> {
    fn take(&mut self) -> Option<Waiting<T>> {
        let waiting = self.waiting.pop()?;
        self.waiting_weight -= waiting.weight;
        Some(waiting)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::Pool;

    #[test]
    fn answers_are_in_the_order_of_making_with_any_number_of_threads() {
        for threads in [0, 1, 2, 7] {
            for allowed in [0, 10, 1_000_000] {
                let heard = AtomicUsize::new(0);
                let progress = |_: usize, _: usize| {
                    heard.fetch_add(1, Ordering::Relaxed);
                };
                let (indices, answers) =
                    Pool::run(threads, allowed, &|task: usize| task * 2, &progress, |pool| {
                        (0..100).map(|task| pool.add(task % 7, task)).collect::<Vec<_>>()
                    });
                assert_eq!(indices, (0..100).collect::<Vec<_>>());
                assert_eq!(answers, (0..100).map(|task| task * 2).collect::<Vec<_>>());
                assert_eq!(heard.into_inner(), 100);
            }
        }
    }

    #[test]
    fn no_more_waits_than_is_allowed() {
        for threads in [1, 3] {
            let (made, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
            let work = |_: usize| {
                done.fetch_add(1, Ordering::SeqCst);
            };
            Pool::run(threads, 5, &work, &|_, _| {}, |pool| {
                for task in 0..200 {
                    made.fetch_add(1, Ordering::SeqCst);
                    pool.add(1, task);
                    let open = made.load(Ordering::SeqCst) - done.load(Ordering::SeqCst);
                    assert!(open <= 5 + threads, "{open} tasks wait or are in work");
                }
            });
        }
    }

    #[test]
    fn a_panic_ends_all_threads_and_keeps_its_message() {
        let run = || Pool::run(3, 5, &|_: usize| {}, &|_, _| {}, |_| -> () { panic!("on purpose") });
        assert!(std::panic::catch_unwind(run).is_err());
        for threads in [1, 2, 3] {
            for victim in 0..20 {
                let work = |task: usize| assert!(task != victim, "on purpose, with {task}");
                let run = || {
                    Pool::run(threads, 5, &work, &|_, _| {}, |pool| {
                        for task in 0..20 {
                            pool.add(1, task);
                        }
                    })
                };
                let panic = std::panic::catch_unwind(run).expect_err("a task panics");
                let message = panic.downcast_ref::<String>().expect("the message of the task");
                assert_eq!(*message, format!("on purpose, with {victim}"));
            }
        }
    }
}
