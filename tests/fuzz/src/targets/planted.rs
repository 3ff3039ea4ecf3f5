//! A target that fails in each way that there is, to see that each is noticed.

use crate::mutation::Choices;
use crate::target::{Kind, Target};
use crate::worker::{MOST, note, processor_time};

pub(crate) const PLANTED: Target = Target {
    name: "planted",
    about: "a panic, an endless sum, memory without end",
    kind: Kind::Function(planted),
    files: &[],
    aim: 1,
};

fn planted(choices: &mut Choices<'_>) {
    let kind = choices.below(40);
    note(kind.to_string());
    match kind {
        10..=13 => panic!("planted"),
        20 => {
            // On another thread, as templates are proven.
            let spin = || {
                let start = processor_time();
                while cfg!(unix) && processor_time() < start + MOST + MOST / 10 {}
            };
            std::thread::spawn(spin).join().unwrap_or_default();
        }
        30 => {
            let mut all: Vec<Vec<u8>> = Vec::new();
            while all.len() < 4096 {
                all.push(vec![1; 1 << 20]);
            }
            assert!(all.iter().all(|each| each.len() == 1 << 20));
        }
        _ => {}
    }
}
