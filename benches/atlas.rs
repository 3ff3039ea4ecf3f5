//! The shadow atlas: the time of a frame, and tiles against two general allocators of rectangles.
//!
//! Frames: 10,000 lights ask for a tile each, while the camera stands, while it moves (each light's wanted size changes
//! a little), and while a tenth of the lights come and go. Lines `ratio atlas/frame/… VALUE` are divided by the bound
//! that is aimed at, 2 ms.
//!
//! Tiles: one sequence of allocations and releases keeps an atlas of 4096 texels filled to a share; sides are powers of
//! two from 32 to 512. Counted are first tries that fail although the area is free. Lines
//! `ratio atlas/fill_…/RIVAL_…` are ours divided by theirs. The rivals take any rectangles, and give theirs no
//! alignment.
//!
//! Times are the minimum of several runs in a row.

use std::time::{Duration, Instant};

use umbragraph_passes::atlas::{
    Capacity, Fate, Key, Placement, Pool, Request, Settings, Tile, TileAllocator, TileRequest,
};
use umbragraph_test_support::random::Random;

fn main() {
    frames();
    for fill in [70, 85, 95] {
        tiles(fill);
    }
}

const LIGHTS: u32 = 10_000;

fn frames() {
    println!("milliseconds for a frame of {LIGHTS} lights");
    let pools = Pool::counts(&[(Pool::Descriptors, LIGHTS), (Pool::Views, LIGHTS)]);
    let settings =
        Settings { max_tile: 1024, min_side: 8192, max_side: 8192, max_pools: pools, ..Settings::default() };
    let capacity = Capacity { side: 8192, pools };
    let request = |light: u32, importance: f32| Request {
        key: Key(u64::from(light) * 0x9E37_79B9_7F4A_7C15),
        importance,
        tiles: TileRequest { count: 1, wanted: (importance * 128.0) as u32, min: 16 },
        slots: Pool::counts(&[(Pool::Descriptors, 1), (Pool::Views, 1)]),
    };
    let base: Vec<f32> = {
        let mut random = Random(7);
        (0..LIGHTS).map(|_| 0.05 + random.below(1000) as f32 / 1000.0).collect()
    };
    for (name, moves) in [("camera_stands", 0), ("camera_moves", 1), ("lights_come_and_go", 2)] {
        let mut placement = Placement::new(settings);
        let mut min = Duration::MAX;
        let mut total = Duration::ZERO;
        let rounds = 60;
        for frame in 0..rounds {
            let requests: Vec<Request> = (0..LIGHTS)
                .map(|light| {
                    let wave = (f64::from(light) * 0.37 + f64::from(frame) * 0.05).sin() as f32;
                    let importance = base[light as usize] * (1.0 + if moves > 0 { 0.3 * wave } else { 0.0 });
                    // A tenth of the lights are others than in the frame before.
                    let turn = if moves == 2 && light % 10 == frame % 10 { LIGHTS * (frame + 1) } else { 0 };
                    request(light + turn, importance)
                })
                .collect();
            let start = Instant::now();
            placement.update(&requests, &capacity);
            let time = start.elapsed();
            if frame >= 10 {
                min = min.min(time);
                total += time;
            }
        }
        let evicted = placement.grants().filter(|grant| matches!(grant.fate, Fate::Evicted(_))).count();
        let mean = total.as_secs_f64() * 1e3 / f64::from(rounds - 10);
        println!(
            "{name:<20} min {:.3}, mean {mean:.3}, {evicted} lights evicted in the last frame",
            min.as_secs_f64() * 1e3
        );
        println!("ratio atlas/frame/{name}_to_2ms {:.3}", mean / 2.0);
    }
}

/// An allocator of squares in an atlas of a given side.
trait Allocator {
    type Id;
    fn allocate(&mut self, side: u32) -> Option<Self::Id>;
    fn release(&mut self, id: Self::Id);
}

impl Allocator for TileAllocator {
    type Id = Tile;
    fn allocate(&mut self, side: u32) -> Option<Tile> {
        TileAllocator::allocate(self, side)
    }
    fn release(&mut self, id: Tile) {
        TileAllocator::release(self, id);
    }
}

macro_rules! rival {
    ($rival:ident::$allocator:ident) => {
        impl Allocator for $rival::$allocator {
            type Id = $rival::AllocId;
            fn allocate(&mut self, side: u32) -> Option<Self::Id> {
                Self::allocate(self, $rival::size2(side as i32, side as i32)).map(|allocation| allocation.id)
            }
            fn release(&mut self, id: Self::Id) {
                self.deallocate(id);
            }
        }
    };
}

rival!(etagere::BucketedAtlasAllocator);
rival!(etagere::AtlasAllocator);
rival!(guillotiere::AtlasAllocator);

const SIDE: u32 = 4096;

/// Returns the number of first attempts, the number of those that failed, and the total time.
fn run<A: Allocator>(mut allocator: A, fill: u64) -> (u32, u32, Duration) {
    let mut random = Random(42);
    let area = u64::from(SIDE) * u64::from(SIDE);
    let (mut used, mut tries, mut failures) = (0, 0, 0);
    let mut held: Vec<(A::Id, u64)> = Vec::new();
    let start = Instant::now();
    for _ in 0..60_000 {
        let side = 32u32 << random.below(5);
        let size = u64::from(side) * u64::from(side);
        // What is not wanted any more makes room, so that the area that is asked for is always free.
        while used + size > area * fill / 100 && !held.is_empty() {
            let at = random.below(held.len());
            let (id, size) = held.swap_remove(at);
            allocator.release(id);
            used -= size;
        }
        tries += 1;
        match allocator.allocate(side) {
            Some(id) => {
                held.push((id, size));
                used += size;
            }
            None => failures += 1,
        }
    }
    (tries, failures, start.elapsed())
}

/// Returns the result of the fastest of several runs.
fn best<A: Allocator>(make: impl Fn() -> A, fill: u64) -> (u32, u32, Duration) {
    (0..5).map(|_| run(make(), fill)).min_by_key(|(_, _, time)| *time).unwrap_or_default()
}

fn tiles(fill: u64) {
    let size = (SIDE as i32, SIDE as i32);
    let ours = best(
        || {
            let mut allocator = TileAllocator::new(32, SIDE);
            assert!(allocator.set_side(SIDE));
            allocator
        },
        fill,
    );
    let rivals = [
        ("etagere", best(|| etagere::AtlasAllocator::new(etagere::size2(size.0, size.1)), fill)),
        (
            "etagere_bucketed",
            best(|| etagere::BucketedAtlasAllocator::new(etagere::size2(size.0, size.1)), fill),
        ),
        ("guillotiere", best(|| guillotiere::AtlasAllocator::new(guillotiere::size2(size.0, size.1)), fill)),
    ];
    println!("tiles in an atlas filled to {fill} %: first tries that fail, nanoseconds for each try");
    let line = |name: &str, (tries, failures, time): (u32, u32, Duration)| {
        println!(
            "{name:<18} {:>6.2} % {:>8.0}",
            100.0 * f64::from(failures) / f64::from(tries),
            time.as_secs_f64() * 1e9 / f64::from(tries)
        );
    };
    line("umbragraph", ours);
    for (name, theirs) in rivals {
        line(name, theirs);
        println!(
            "ratio atlas/fill_{fill}/{name}_failures {:.3}",
            f64::from(ours.1) / f64::from(theirs.1.max(1))
        );
        println!("ratio atlas/fill_{fill}/{name}_time {:.3}", ours.2.as_secs_f64() / theirs.2.as_secs_f64());
    }
}
