//! A minute of random input: the window lives, and its memory stays as it was.

use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::hand::SIZE;
use crate::start;
use crate::x11::{CONTROL, ESCAPE, SHIFT};

/// A pseudo-random number generator: G. Marsaglia's xorshift.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % end
    }

    fn point(&mut self) -> [i16; 2] {
        SIZE.map(|side| self.below(u64::from(side)) as i16)
    }
}

pub(crate) fn variable(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

#[test]
fn random_input_neither_ends_nor_bloats_the_window() {
    let Some(mut hand) = start("random", &["--scale", "0.25"]) else { return };
    hand.settle();
    let seed = variable("UMBRAGRAPH_SEED", 7);
    let seconds = variable("UMBRAGRAPH_VIEW_SECONDS", 60);
    println!("UMBRAGRAPH_SEED={seed} UMBRAGRAPH_VIEW_SECONDS={seconds}");
    let mut random = Random::new(seed);
    let begin = Instant::now();
    let mut warm = None;
    let mut count = 0;
    while begin.elapsed() < Duration::from_secs(seconds) {
        match random.below(10) {
            0..=4 => {
                let at = random.point();
                hand.display.click(at);
            }
            5 | 6 => {
                let (from, to) = (random.point(), random.point());
                hand.display.drag(from, to);
            }
            7 => {
                let (at, wheel) = (random.point(), 4 + random.below(2) as u8);
                hand.display.move_to(at);
                hand.display.button(wheel, true);
                hand.display.button(wheel, false);
            }
            _ => {
                let key = u32::from(b"abdegnoptw12345/.-+= "[random.below(21) as usize]);
                let held = [&[][..], &[SHIFT], &[CONTROL]][random.below(3) as usize];
                // Ctrl+S would fill the disk with nothing new; Ctrl+W and the like mean nothing here.
                hand.display.press(held, key);
            }
        }
        count += 1;
        assert!(
            hand.is_running(),
            "after {count} inputs of the seed {seed} the window is gone: {}",
            hand.said()
        );
        if warm.is_none() && begin.elapsed().as_secs() * 2 >= seconds {
            warm = Some(hand.memory());
        }
    }
    // Whatever is open is closed, and the animation stands: while it plays a frame never settles.
    for _ in 0..3 {
        hand.display.press(&[], ESCAPE);
    }
    // Ctrl and + or − have scaled the window, whose points are pixels only without a scale.
    hand.display.press(&[CONTROL], u32::from('0'));
    sleep(Duration::from_secs(2));
    hand.leave_text();
    if hand.state()["playing"] == true {
        hand.display.press(&[], u32::from(' '));
        hand.wait("pause", |state| state["playing"] == false);
    }
    hand.settle();
    let said = hand.said();
    assert!(!said.contains("panicked"), "{said}");
    let (warm, end) = (warm.unwrap_or_default(), hand.memory());
    println!(
        "{count} inputs; {} MB after half of the time, {} MB at the end",
        warm / 1_000_000,
        end / 1_000_000
    );
    assert!(end < warm + warm / 4 + 64_000_000, "memory went from {warm} to {end} bytes");
}
