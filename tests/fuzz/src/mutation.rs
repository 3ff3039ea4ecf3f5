//! Random choices, and changes of texts and bytes that they make.

use arbitrary::Unstructured;

/// Random choices. Once their bytes are used up, each is the first of what there is.
pub(crate) struct Choices<'b>(Unstructured<'b>);

impl<'b> Choices<'b> {
    pub(crate) fn new(bytes: &'b [u8]) -> Self {
        Self(Unstructured::new(bytes))
    }

    /// A number below another; 0 where that is 0.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        self.0.int_in_range(0..=end.max(1) - 1).unwrap_or_default()
    }

    pub(crate) fn one_of<'l, T>(&mut self, list: &'l [T]) -> &'l T {
        &list[self.below(list.len())]
    }

    pub(crate) fn number<T: for<'a> arbitrary::Arbitrary<'a> + Default>(&mut self) -> T {
        self.0.arbitrary().unwrap_or_default()
    }
}

/// Values that are odd almost everywhere.
pub(crate) const ODD: [&str; 24] = [
    "null",
    "true",
    "0",
    "-1",
    "1e308",
    "1e999",
    "4294967296",
    "0.5",
    "\"\"",
    "\"=1/0\"",
    "\"=viewport\"",
    "\"=viewport.width * 1e9\"",
    "\"&picture\"",
    "\"&a.b@c@-1\"",
    "[]",
    "{}",
    "[[[]]]",
    "\"ä€😀\"",
    "\"\\u0000\"",
    "\"{\"",
    "\"{n}\"",
    "\"NaN\"",
    "// \n",
    "\u{feff}",
];

/// The pieces of a text: strings, words and numbers, and single other characters.
fn pieces(text: &str) -> Vec<&str> {
    let (mut pieces, mut rest) = (Vec::new(), text);
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '"' => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
            _ if first.is_alphanumeric() => {
                let is_other = |c: char| !c.is_alphanumeric() && c != '.' && c != '_';
                rest.find(is_other).unwrap_or(rest.len())
            }
            _ => first.len_utf8(),
        };
        let (piece, behind) = rest.split_at(length);
        pieces.push(piece);
        rest = behind;
    }
    pieces
}

/// A text with one to four pieces changed; `other` lends pieces.
pub(crate) fn changed(text: &str, other: &str, choices: &mut Choices<'_>) -> String {
    let (mut own, others) = (pieces(text), pieces(other));
    for _ in 0..=choices.below(4) {
        // Strings and words: changes of them mostly leave something to be read.
        let words: Vec<usize> = (0..own.len()).filter(|at| own[*at].len() > 1).collect();
        if words.is_empty() {
            break;
        }
        let (at, second) = (*choices.one_of(&words), *choices.one_of(&words));
        match choices.below(9) {
            0 => drop(own.remove(at)),
            1 => own.insert(at, own[second]),
            2 => own.swap(at, second),
            3 => own[at] = own[second],
            4 => own.truncate(at),
            5 if !others.is_empty() => own[at] = others[choices.below(others.len())],
            6 => {
                let end = at + choices.below(30).min(own.len() - at);
                let copied = own[at..end].to_vec();
                own.splice(second..second, copied);
            }
            _ => own[at] = choices.one_of::<&str>(&ODD),
        }
    }
    own.concat()
}

/// Bytes with one to eight changes.
pub(crate) fn changed_bytes(bytes: &mut Vec<u8>, choices: &mut Choices<'_>) {
    for _ in 0..=choices.below(8) {
        let at = choices.below(bytes.len());
        match choices.below(6) {
            0 => bytes.truncate(at),
            1 => {
                let end = (at + choices.below(64)).min(bytes.len());
                let copied = bytes.get(at..end).unwrap_or_default().to_vec();
                let to = choices.below(bytes.len());
                bytes.splice(to..to, copied);
            }
            2 => {
                let number: u32 = *choices.one_of(&[0, 1, u32::MAX, i32::MAX as u32, 1 << 16, 255]);
                for (byte, new) in bytes.iter_mut().skip(at).zip(number.to_le_bytes()) {
                    *byte = new;
                }
            }
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = choices.number();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_the_whole_text() {
        for text in ["", "\"", "{ \"a\": [1.5, b_c], \"ä\" }\n", "😀\"x"] {
            assert_eq!(pieces(text).concat(), text);
        }
    }

    #[test]
    fn without_bytes_there_are_choices_still() {
        let text = "{ \"a\": 12 }";
        let mut choices = Choices::new(&[]);
        assert_ne!(changed(text, "", &mut choices), text);
        changed_bytes(&mut Vec::new(), &mut choices);
    }
}
