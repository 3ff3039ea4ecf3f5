//! Reuse of textures and buffers by the plan that replaces another.
//!
//! An object can serve any resource with the same descriptor. A resource that outlives frames keeps its contents under
//! its own name and under no other; a new resource of that kind begins empty. A resource within a frame is written
//! before it is read, so any object of its kind will do; one with the same label is preferred.
//!
//! Cost: linear in both plans, but for hashing.

use std::collections::HashMap;
use std::hash::Hash;

/// A texture or buffer of the previous plan or of the new one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Piece<'a, D> {
    /// The descriptor; objects with equal descriptors are interchangeable.
    pub(crate) descriptor: D,
    /// The name of the resource whose contents outlive a frame in this object; `None` if no contents outlive a frame.
    pub(crate) keeps: Option<&'a str>,
    /// The label; an old object with the same label is preferred.
    pub(crate) label: &'a str,
}

/// Returns, for each piece of the new plan, the index of the old piece to reuse; `None` if one must be created.
pub(crate) fn reuse<D: Hash + Eq + Copy>(old: &[Piece<'_, D>], new: &[Piece<'_, D>]) -> Vec<Option<usize>> {
    // From the back, so that taking the last of a list takes the first of the plan.
    let mut free: HashMap<(D, Option<&str>), Vec<usize>> = HashMap::new();
    for (at, piece) in old.iter().enumerate().rev() {
        free.entry((piece.descriptor, piece.keeps)).or_default().push(at);
    }
    let mut by_label: HashMap<(D, Option<&str>, &str), usize> = HashMap::new();
    for (at, piece) in old.iter().enumerate().rev() {
        by_label.insert((piece.descriptor, piece.keeps, piece.label), at);
    }
    let mut taken = vec![false; old.len()];
    let mut found: Vec<Option<usize>> = new
        .iter()
        .map(|piece| {
            let at = *by_label.get(&(piece.descriptor, piece.keeps, piece.label))?;
            (!std::mem::replace(&mut taken[at], true)).then_some(at)
        })
        .collect();
    for (piece, found) in new.iter().zip(&mut found).filter(|(_, found)| found.is_none()) {
        let Some(list) = free.get_mut(&(piece.descriptor, piece.keeps)) else { continue };
        while let Some(at) = list.pop() {
            if !std::mem::replace(&mut taken[at], true) {
                *found = Some(at);
                break;
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transient(descriptor: u32, label: &str) -> Piece<'_, u32> {
        Piece { descriptor, keeps: None, label }
    }

    fn kept(descriptor: u32, name: &str) -> Piece<'_, u32> {
        Piece { descriptor, keeps: Some(name), label: name }
    }

    #[test]
    fn equal_descriptors_go_on_and_others_do_not() {
        let old = [transient(1, "a"), transient(2, "b")];
        assert_eq!(
            reuse(&old, &[transient(2, "c"), transient(3, "a"), transient(1, "b")]),
            [Some(1), None, Some(0)]
        );
    }

    #[test]
    fn nothing_stands_for_two() {
        let old = [transient(1, "a")];
        assert_eq!(reuse(&old, &[transient(1, "b"), transient(1, "c")]), [Some(0), None]);
        assert_eq!(reuse(&old, &[transient(1, "b"), transient(1, "a")]), [None, Some(0)]);
    }

    #[test]
    fn the_same_label_comes_first() {
        let old = [transient(1, "a"), transient(1, "b")];
        assert_eq!(reuse(&old, &[transient(1, "b"), transient(1, "c")]), [Some(1), Some(0)]);
    }

    #[test]
    fn contents_are_kept_under_their_own_name_only() {
        let old = [kept(1, "a"), transient(1, "t")];
        assert_eq!(reuse(&old, &[kept(1, "b"), kept(1, "a"), transient(1, "u")]), [None, Some(0), Some(1)]);
        assert_eq!(reuse(&old, &[kept(2, "a")]), [None]);
        assert_eq!(reuse(&old[..1], &[transient(1, "a")]), [None]);
    }
}
