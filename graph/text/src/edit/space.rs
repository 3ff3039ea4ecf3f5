//! The edits between two texts that differ in space.

use super::layout::SPACE;
use super::{Edit, Edits};

/// Returns the edits that turn `old` into `new`. If the texts differ only in white space, the edits change only white
/// space. Otherwise everything from the first other difference on is replaced.
pub fn between(old: &str, new: &str) -> Edits {
    let (mut list, mut at, mut at_new) = (Vec::new(), 0, 0);
    let space = |text: &str| text.len() - text.trim_start_matches(SPACE).len();
    loop {
        let (rest, rest_new) = (&old[at..], &new[at_new..]);
        let (before, before_new) = (space(rest), space(rest_new));
        if rest[..before] != rest_new[..before_new] {
            let replacement = rest_new[..before_new].to_owned();
            list.push(Edit { range: at..at + before, replacement });
        }
        let (rest, rest_new) = (&rest[before..], &rest_new[before_new..]);
        let alike = rest.bytes().zip(rest_new.bytes());
        let alike = alike.take_while(|(old, new)| old == new && !SPACE.contains(&char::from(*old)));
        let mut length = alike.count();
        while !rest.is_char_boundary(length) {
            length -= 1;
        }
        (at, at_new) = (at + before + length, at_new + before_new + length);
        if length == 0 {
            break;
        }
    }
    if (at, at_new) != (old.len(), new.len()) {
        list.push(Edit { range: at..old.len(), replacement: new[at_new..].to_owned() });
    }
    Edits { list }
}
