//! A size that follows a need: up at once, and down when the need has been lower for some frames in a row, to the most
//! that was needed in them.

/// A size that rises with a need at once, and falls only after the need was lower for some frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Follower {
    value: u32,
    calm: u32,
    max: u32,
}

impl Follower {
    /// Returns the size for a frame in which `need` is needed. After `patience` consecutive frames with a lower need,
    /// the size falls to the maximum need of these frames.
    pub(super) fn follow(&mut self, need: u32, patience: u32) -> u32 {
        if need >= self.value {
            *self = Self { value: need, calm: 0, max: 0 };
            return need;
        }
        self.calm += 1;
        self.max = self.max.max(need);
        if self.calm >= patience {
            *self = Self { value: self.max, calm: 0, max: 0 };
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn size_rises_at_once_and_falls_later_to_the_recent_need() {
        let mut follower = Follower::default();
        let needs = [4, 8, 2, 4, 2, 2, 2, 2, 9, 1, 1, 9, 1];
        let sizes = needs.map(|need| follower.follow(need, 3));
        assert_eq!(sizes, [4, 8, 8, 8, 4, 4, 4, 2, 9, 9, 9, 9, 9]);
        assert_eq!(Follower::default().follow(0, 0), 0);
    }
}
