//! The data sizes that CPU passes request, which a plan may have only so often.

use std::collections::BTreeMap;

/// The maximum number of other data sizes, and so of plans, that CPU passes may request before they are content.
const ROUNDS: usize = 8;

/// The requested data sizes, and the number of requests.
#[derive(Default)]
pub(crate) struct Sizes {
    /// The sizes of the last request; `None` before the first one.
    pub(crate) wanted: Option<BTreeMap<String, u32>>,
    /// The number of different requests in a row, without a frame in between whose sizes were right.
    rounds: usize,
}

impl Sizes {
    /// Takes the request of a frame, `None` if its sizes were right. Returns `true` if there is to be another plan.
    pub(crate) fn request(&mut self, wanted: Option<BTreeMap<String, u32>>) -> bool {
        // Frames until the plan is there repeat the request.
        match wanted {
            None => self.rounds = 0,
            Some(_) if self.wanted == wanted || self.rounds == ROUNDS => {}
            wanted => {
                (self.wanted, self.rounds) = (wanted, self.rounds + 1);
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endless_requests_of_sizes_end() {
        let mut sizes = Sizes::default();
        let wanted = |size: u32| Some(BTreeMap::from([("lights".to_owned(), size)]));
        assert!(sizes.request(wanted(1)) && !sizes.request(wanted(1)), "one plan for one request");
        // Each of two plans wants the sizes of the other.
        let plans = (0..99).filter(|round| sizes.request(wanted(2 + round % 2))).count();
        assert_eq!(plans, ROUNDS - 1);
        assert!(!sizes.request(None) && sizes.request(wanted(4)), "content once, it may want again");
    }
}
