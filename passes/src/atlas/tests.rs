//! The atlas against plain oracles: many random operations, orders, overflow, growth.

use std::collections::BTreeMap;

use umbragraph_test_support::random::Random;

use super::*;

/// The tile that covers each square of the smallest size in an atlas; `None` for a free square.
struct Canvas {
    across: usize,
    unit: u32,
    squares: Vec<Option<Tile>>,
}

impl Canvas {
    fn new(side: u32, unit: u32) -> Self {
        let across = (side / unit) as usize;
        Self { across, unit, squares: vec![None; across * across] }
    }

    fn paint(&mut self, tile: Tile, before: Option<Tile>, after: Option<Tile>) {
        let [x, y, size] = [tile.x, tile.y, tile.size].map(|texels| (texels / self.unit) as usize);
        for row in y..y + size {
            for square in &mut self.squares[row * self.across + x..row * self.across + x + size] {
                assert_eq!(*square, before, "{tile:?} overlaps");
                *square = after;
            }
        }
    }

    /// Returns `true` if an aligned square with a side of `size` texels is free.
    fn has_room(&self, size: u32) -> bool {
        let step = (size / self.unit) as usize;
        (0..self.across / step).any(|row| {
            (0..self.across / step).any(|column| {
                (0..step * step).all(|at| {
                    let (y, x) = (row * step + at / step, column * step + at % step);
                    self.squares[y * self.across + x].is_none()
                })
            })
        })
    }
}

#[test]
fn many_operations_leave_tiles_apart_in_bounds_and_aligned() {
    let (side, unit) = (2048, 16);
    let mut atlas = TileAllocator::new(unit, side);
    let mut twin = TileAllocator::new(unit, side);
    assert!(atlas.set_side(side) && twin.set_side(side));
    let mut canvas = Canvas::new(side, unit);
    let mut tiles: Vec<Tile> = Vec::new();
    let mut random = Random(1);
    let mut failed = 0;
    for step in 0..200_000 {
        let crowded = if step / 10_000 % 2 == 0 { 40 } else { 55 };
        if random.below(100) < crowded && !tiles.is_empty() {
            let tile = tiles.swap_remove(random.below(tiles.len()));
            assert!(atlas.release(tile) && twin.release(tile));
            assert!(!atlas.release(tile), "a second release is rejected");
            canvas.paint(tile, Some(tile), None);
        } else {
            let size = 16u32 << random.below(8).min(random.below(8));
            let tile = atlas.allocate(size);
            assert_eq!(tile, twin.allocate(size), "the same calls give the same tiles");
            match tile {
                Some(tile) => {
                    assert_eq!(tile.size, size);
                    assert!(tile.x % size == 0 && tile.y % size == 0);
                    assert!(tile.x + size <= side && tile.y + size <= side);
                    canvas.paint(tile, None, Some(tile));
                    tiles.push(tile);
                }
                None => {
                    failed += 1;
                    if failed % 50 == 0 {
                        assert!(!canvas.has_room(size), "a free square of {size} was not found");
                    }
                }
            }
        }
        assert_eq!(atlas.used_area, tiles.iter().map(|tile| tile.area()).sum::<u64>());
    }
    assert!(failed > 1000, "the atlas was full now and then: {failed}");
    for tile in tiles {
        assert!(atlas.release(tile));
    }
    assert_eq!(atlas.allocate(side), Some(Tile { x: 0, y: 0, size: side }), "all free squares are one again");
}

#[test]
fn misuse_of_an_allocator_is_rejected_and_changes_nothing() {
    let mut atlas = TileAllocator::new(0, u32::MAX);
    assert_eq!((atlas.min, atlas.side), (MIN_TILE, 0));
    assert_eq!(atlas.allocate(16), None);
    assert!(atlas.set_side(100));
    assert_eq!(atlas.side, 64);
    assert_eq!((atlas.allocate(65), atlas.allocate(u32::MAX)), (None, None));
    let tile = atlas.allocate(0).unwrap();
    assert_eq!(tile, Tile { x: 0, y: 0, size: 16 });
    let wrong = [
        Tile::NONE,
        Tile { size: 32, ..tile },
        Tile { x: 16, ..tile },
        Tile { x: 3, ..tile },
        Tile { x: 1 << 20, ..tile },
        Tile { size: 24, ..tile },
        Tile { x: u32::MAX, y: u32::MAX, size: u32::MAX },
    ];
    for wrong in wrong {
        assert!(!atlas.release(wrong), "{wrong:?}");
    }
    assert_eq!((atlas.side, atlas.used_area), (64, 256));
}

#[test]
fn an_atlas_grows_and_shrinks_around_its_tiles() {
    let mut atlas = TileAllocator::new(16, 1024);
    assert!(atlas.set_side(64));
    let tiles: Vec<Tile> = (0..16).map(|_| atlas.allocate(16).unwrap()).collect();
    assert_eq!(atlas.allocate(16), None);
    assert!(atlas.set_side(256));
    assert_eq!(atlas.used_area, 64 * 64);
    let beyond: Vec<Tile> = (0..15).map(|_| atlas.allocate(64).unwrap()).collect();
    assert!(beyond.iter().all(|tile| tiles.iter().all(|small| !small.overlaps(*tile))));
    assert_eq!(atlas.allocate(16), None);
    assert!(!atlas.set_side(128));
    assert_eq!(atlas.side, 256, "rejected");
    assert!(beyond.into_iter().all(|tile| atlas.release(tile)));
    assert!(atlas.set_side(64));
    assert_eq!(atlas.allocate(16), None);
    assert!(!atlas.set_side(0));
    assert!(tiles.into_iter().all(|tile| atlas.release(tile)));
    assert!(atlas.set_side(32) && atlas.set_side(16));
    assert!(atlas.allocate(16).is_some_and(|tile| atlas.release(tile)), "an atlas of one tile");
    assert!(atlas.set_side(0) && atlas.set_side(1024));
    assert_eq!(atlas.allocate(1024).map(|tile| tile.size), Some(1024));
}

const PLENTY: PoolCounts = [u32::MAX; POOLS];

fn request(key: u64, importance: f32, count: u32, wanted: u32, min: u32) -> Request {
    Request {
        key: Key(key),
        importance,
        tiles: TileRequest { count, wanted, min },
        slots: Pool::counts(&[(Pool::Descriptors, count), (Pool::Views, count)]),
    }
}

fn random_requests(random: &mut Random, count: u64) -> Vec<Request> {
    (0..count)
        .map(|key| {
            let importance = random.below(1000) as f32 / 100.0;
            let tiles = [1, 1, 1, 4, 6][random.below(5)];
            let wanted = 16 + random.below(500) as u32;
            request(key, importance, tiles, wanted, 16 << random.below(2))
        })
        .collect()
}

type Granted = BTreeMap<Key, (Fate, Vec<Tile>, PoolCounts)>;

fn granted(placement: &Placement, requests: &[Request]) -> Granted {
    requests
        .iter()
        .zip(placement.grants())
        .map(|(request, grant)| (request.key, (grant.fate, grant.tiles.to_vec(), grant.first_slots)))
        .collect()
}

/// Checks that grants are disjoint, within bounds, aligned, and of the size of their outcome.
fn check(placement: &Placement, requests: &[Request]) {
    let Capacity { side, pools } = placement.capacity;
    let mut canvas = Canvas::new(side.max(16), placement.settings.min_tile);
    let mut runs: [BTreeMap<u32, u32>; POOLS] = Default::default();
    for (request, grant) in requests.iter().zip(placement.grants()) {
        let evicted = matches!(grant.fate, Fate::Evicted(_));
        assert_eq!(grant.tiles.len(), if evicted { 0 } else { request.tiles.count as usize });
        for tile in grant.tiles {
            assert!(tile.size.is_power_of_two() && (tile.x | tile.y) % tile.size == 0);
            assert!(tile.x + tile.size <= side && tile.y + tile.size <= side);
            assert!(tile.size >= request.tiles.min, "{request:?} {grant:?}");
            assert_eq!(tile.size, grant.tiles[0].size);
            if let Fate::Downsized { from, to } = grant.fate {
                assert!(to < from && tile.size == to);
            }
            canvas.paint(*tile, None, Some(*tile));
        }
        if evicted {
            continue;
        }
        for pool in 0..POOLS {
            let (first, count) = (grant.first_slots[pool], request.slots[pool]);
            if count > 0 {
                assert!(first + count <= pools[pool]);
                assert_eq!(runs[pool].insert(first, count), None);
            }
        }
    }
    for runs in runs {
        let mut end = 0;
        for (first, count) in runs {
            assert!(first >= end, "runs overlap");
            end = first + count;
        }
    }
}

#[test]
fn the_order_of_the_requests_decides_nothing() {
    let mut random = Random(2);
    let (mut one, mut two) = (Placement::new(Settings::default()), Placement::new(Settings::default()));
    let mut requests = random_requests(&mut random, 300);
    for frame in 0..60 {
        for _ in 0..20 {
            let at = random.below(requests.len());
            let fresh = random_requests(&mut random, 1)[0];
            requests[at] = Request { key: requests[at].key, ..fresh };
        }
        let shown = &requests[..200 + random.below(100)];
        let mut shuffled = shown.to_vec();
        random.shuffle(&mut shuffled);
        let side = [512, 1024, 2048][frame / 20];
        let capacity = Capacity { side, pools: [300, 350, 0, 0, 0] };
        one.update(shown, &capacity);
        two.update(&shuffled, &capacity);
        check(&one, shown);
        assert_eq!(granted(&one, shown), granted(&two, &shuffled), "frame {frame}");
        assert_eq!(one.wanted(), two.wanted());
        assert_eq!(one.fates_changed(), two.fates_changed());
    }
}

#[test]
fn any_sequence_of_frames_is_placed_validly_and_fills_space() {
    for seed in 0..40 {
        let mut random = Random(100 + seed);
        let mut placement = Placement::new(Settings { min_tile: 16, ..Settings::default() });
        let mut requests = random_requests(&mut random, 120);
        for _ in 0..40 {
            let first = random.below(120);
            for request in random_requests(&mut random, 12) {
                let at = (first + request.key.0 as usize) % requests.len();
                requests[at] = Request { key: requests[at].key, ..request };
            }
            let shown = &requests[random.below(60)..];
            let side = 16u32 << random.below(8);
            let pools = [random.below(300) as u32, random.below(300) as u32, 0, 0, 0];
            placement.update(shown, &Capacity { side, pools });
            check(&placement, shown);
            // Nobody is smaller than asked for while there is room for the next size of its tiles.
            let free = u64::from(side) * u64::from(side) - placement.atlas.used_area;
            for grant in placement.grants() {
                if let Fate::Downsized { to, .. } = grant.fate
                    && to < side
                {
                    assert!(3 * u64::from(to) * u64::from(to) * grant.tiles.len() as u64 > free);
                }
            }
        }
    }
}

#[test]
fn a_light_that_only_wobbles_keeps_its_tiles() {
    let mut random = Random(3);
    let mut placement = Placement::new(Settings::default());
    let base = random_requests(&mut random, 200);
    let capacity = Capacity { side: 1024, pools: PLENTY };
    placement.update(&base, &capacity);
    let before = granted(&placement, &base);
    assert!(before.values().any(|(fate, ..)| matches!(fate, Fate::Downsized { .. })));
    for _ in 0..50 {
        let wobbling: Vec<Request> = base
            .iter()
            .map(|request| {
                let factor = 0.85 + 0.003 * random.below(100) as f32;
                let wanted = (request.tiles.wanted as f32 * factor) as u32;
                // Sizes wobble across the powers of two only where 1 / 1.25 .. 1.25 of a power holds them.
                let power = request.tiles.wanted.next_power_of_two() as f32;
                let wanted = if (wanted as f32) > power / 2.4 { wanted } else { request.tiles.wanted };
                let tiles = TileRequest { wanted, ..request.tiles };
                Request { importance: request.importance * factor, tiles, ..*request }
            })
            .collect();
        placement.update(&wobbling, &capacity);
        assert_eq!(granted(&placement, &wobbling), before);
        assert!(!placement.fates_changed());
    }
    // One more light where there is room moves nobody else.
    let mut placement = Placement::new(Settings::default());
    let roomy = Capacity { side: 8192, pools: PLENTY };
    let mut requests = base[..60].to_vec();
    placement.update(&requests, &roomy);
    let before = granted(&placement, &requests);
    assert!(before.values().all(|(fate, ..)| *fate == Fate::Granted));
    requests.insert(17, request(9999, 3.0, 1, 256, 16));
    requests.remove(30);
    placement.update(&requests, &roomy);
    for (key, now) in granted(&placement, &requests) {
        assert!(key == Key(9999) || before[&key] == now);
    }
}

#[test]
fn overflow_downsizes_and_then_evicts_the_least_important() {
    let mut placement = Placement::new(Settings::default());
    let mut requests: Vec<Request> = (0..16).map(|at| request(at, 1.0 + at as f32, 1, 256, 128)).collect();
    let fates = |placement: &Placement| placement.grants().map(|grant| grant.fate).collect::<Vec<_>>();
    placement.update(&requests, &Capacity { side: 1024, pools: PLENTY });
    assert_eq!(fates(&placement), [Fate::Granted; 16]);
    // Four more take a quarter: the least important of all are halved, one for each three quarters of a tile.
    requests.extend((16..20).map(|at| request(at, 1.0 + at as f32, 1, 256, 128)));
    placement.update(&requests, &Capacity { side: 1024, pools: PLENTY });
    let halved = Fate::Downsized { from: 256, to: 128 };
    let expected: Vec<Fate> = (0..20).map(|at| if at < 6 { halved } else { Fate::Granted }).collect();
    assert_eq!(fates(&placement), expected);
    assert!(placement.fates_changed());
    // A quarter of the atlas holds sixteen at their smallest.
    placement.update(&requests, &Capacity { side: 512, pools: PLENTY });
    let full = Fate::Evicted(Eviction::AtlasFull);
    let expected: Vec<Fate> = (0..20).map(|at| if at < 4 { full } else { halved }).collect();
    assert_eq!(fates(&placement), expected);
    // Whoever is left is served in the same frame.
    requests.truncate(4);
    placement.update(&requests, &Capacity { side: 512, pools: PLENTY });
    assert_eq!(fates(&placement), [Fate::Granted; 4]);
    placement.update(&requests, &Capacity { side: 64, pools: PLENTY });
    assert_eq!(fates(&placement), [Fate::Evicted(Eviction::AtlasTooSmall); 4]);
    assert!(placement.fates_changed());
    placement.update(&requests, &Capacity { side: 0, pools: PLENTY });
    assert_eq!(fates(&placement), [Fate::Evicted(Eviction::AtlasTooSmall); 4]);
    assert!(!placement.fates_changed());
    assert_eq!(placement.atlas.used_area, 0);
    // Room that a large tile leaves when it is halved makes none larger than it asks to be.
    let uneven = [request(30, 1.0, 1, 512, 128), request(31, 2.0, 1, 128, 128)];
    placement.update(&uneven, &Capacity { side: 512, pools: PLENTY });
    assert_eq!(placement.grants().map(|grant| grant.tiles[0].size).collect::<Vec<_>>(), [256, 128]);
}

#[test]
fn overflowing_spots_come_back_when_lights_are_removed() {
    let mut random = Random(5);
    let mut placement = Placement::new(Settings::default());
    let spots: Vec<Request> =
        (0..200).map(|at| request(at, random.below(1000) as f32, 1, 1024, 64)).collect();
    let capacity = Capacity { side: 4096, pools: [150, 150, 0, 0, 0] };
    placement.update(&spots, &capacity);
    check(&placement, &spots);
    let fates: Vec<Fate> = placement.grants().map(|grant| grant.fate).collect();
    let evicted = fates.iter().filter(|fate| matches!(fate, Fate::Evicted(_))).count();
    assert_eq!(evicted, 50);
    let min_kept = spots.iter().zip(&fates).filter(|(_, fate)| !matches!(fate, Fate::Evicted(_)));
    let min_kept = min_kept.map(|(spot, _)| spot.importance).fold(f32::MAX, f32::min);
    for (spot, fate) in spots.iter().zip(&fates) {
        if matches!(fate, Fate::Evicted(_)) {
            assert!(spot.importance <= min_kept);
            assert_eq!(*fate, Fate::Evicted(Eviction::PoolFull(Pool::Descriptors)));
        }
    }
    placement.update(&spots[..16], &capacity);
    assert!(placement.grants().all(|grant| grant.fate == Fate::Granted && grant.tiles[0].size == 1024));
}

#[test]
fn every_pool_is_limited_by_importance_and_names_itself() {
    for (pool, name) in Pool::ALL.into_iter().zip(["descriptors", "views", "cubes", "layers", "spots"]) {
        let mut placement = Placement::new(Settings::default());
        let slots = |count| Pool::counts(&[(pool, count)]);
        let of = |key, importance, count| Request {
            key: Key(key),
            importance,
            tiles: TileRequest::NONE,
            slots: slots(count),
        };
        let requests = [of(1, 1.0, 1), of(2, 9.0, 2), of(3, 5.0, 2), of(4, 7.0, 4), of(5, 0.5, 1)];
        placement.update(&requests, &Capacity { side: 0, pools: slots(3) });
        let fates: Vec<Fate> = placement.grants().map(|grant| grant.fate).collect();
        assert_eq!(
            fates,
            [
                Fate::Granted,
                Fate::Granted,
                Fate::Evicted(Eviction::PoolFull(pool)),
                Fate::Evicted(Eviction::PoolTooSmall(pool)),
                Fate::Evicted(Eviction::PoolFull(pool)),
            ]
        );
        check(&placement, &requests);
        let words = [Eviction::PoolFull(pool), Eviction::PoolTooSmall(pool)].map(|why| why.to_string());
        let full = format!("more important lights take all shadow {name}");
        assert_eq!(words, [full, format!("it needs more shadow {name} than there are")]);
    }
}

#[test]
fn scattered_slots_are_closed_up_where_a_run_needs_them() {
    let mut placement = Placement::new(Settings::default());
    let of = |key, count| Request {
        key: Key(key),
        importance: 1.0,
        tiles: TileRequest::NONE,
        slots: Pool::counts(&[(Pool::Layers, count)]),
    };
    let capacity = Capacity { side: 0, pools: Pool::counts(&[(Pool::Layers, 6)]) };
    let six: Vec<Request> = (0..6).map(|key| of(key, 1)).collect();
    placement.update(&six, &capacity);
    let slots = |placement: &Placement| {
        placement.grants().map(|grant| grant.first_slots[Pool::Layers as usize]).collect::<Vec<_>>()
    };
    placement.update(&six[1..], &capacity);
    assert_eq!(slots(&placement), [1, 2, 3, 4, 5], "who stays keeps its slot");
    let four = [of(0, 1), of(2, 1), of(4, 1), of(9, 3)];
    placement.update(&four, &capacity);
    check(&placement, &four);
    assert_eq!(slots(&placement), [0, 1, 2, 3]);
}

#[test]
fn the_wanted_capacity_rises_at_once_and_falls_after_a_while() {
    let settings = Settings { min_side: 64, max_side: 1024, patience: 3, ..Settings::default() };
    let mut placement = Placement::new(settings);
    placement.update(&[], &Capacity::default());
    assert_eq!(placement.wanted().side, 64, "an atlas for nothing is the smallest");
    let many: Vec<Request> = (0..20).map(|at| request(at, 1.0, 1, 128, 16)).collect();
    let update = |placement: &mut Placement, requests: &[Request]| {
        let capacity = *placement.wanted();
        placement.update(requests, &capacity);
        placement.wanted().side
    };
    assert_eq!(update(&mut placement, &many), 1024);
    assert_eq!(placement.wanted().pools, [20, 20, 0, 0, 0]);
    assert!(placement.grants().all(|grant| matches!(grant.fate, Fate::Evicted(_))), "there was no atlas yet");
    assert_eq!(update(&mut placement, &many), 1024);
    assert!(placement.grants().all(|grant| grant.fate == Fate::Granted));
    let sides: Vec<u32> = (0..4).map(|_| update(&mut placement, &many[..4])).collect();
    assert_eq!(sides, [1024, 1024, 256, 256]);
    check(&placement, &many[..4]);
    assert!(placement.grants().all(|grant| grant.fate == Fate::Granted));
    assert_eq!(update(&mut placement, &[request(0, 1.0, 8, 8192, 16)]), 1024);
    // The size of no tiles counts for nothing.
    let sides: Vec<u32> = (0..3).map(|_| update(&mut placement, &[request(0, 1.0, 0, 512, 16)])).collect();
    assert_eq!(sides[2], 64);
    assert_eq!(placement.wanted().pools, [0; POOLS]);
}

#[test]
fn senseless_requests_are_placed_or_evicted_all_the_same() {
    let mut placement = Placement::new(Settings {
        min_tile: 0,
        max_tile: u32::MAX,
        min_side: u32::MAX,
        max_side: 0,
        tolerance: f32::NAN,
        ..Settings::default()
    });
    let broken = [f32::NAN, f32::INFINITY, -1.0, f32::MAX, 0.0];
    let requests: Vec<Request> = broken
        .iter()
        .enumerate()
        .map(|(at, importance)| Request {
            slots: [u32::MAX; POOLS],
            ..request(at as u64, *importance, u32::MAX, u32::MAX, at as u32)
        })
        .collect();
    for side in [0, 15, 16, 1000, u32::MAX] {
        placement.update(&requests, &Capacity { side, pools: PLENTY });
        assert_eq!(placement.grants().filter(|grant| grant.fate == Fate::Granted).count(), 0);
    }
    let free: Vec<Request> =
        requests.iter().map(|request| Request { slots: [0; POOLS], ..*request }).collect();
    placement.update(&free, &Capacity { side: 1024, pools: PLENTY });
    assert!(placement.grants().all(|grant| grant.tiles.len() == MAX_TILES));
    assert_eq!(placement.grant(free.len()), None);
}

#[test]
fn requests_of_one_key_are_one_request() {
    let mut placement = Placement::new(Settings::default());
    let mut twice = vec![request(1, 1.0, 1, 64, 16), request(1, 2.0, 2, 32, 16), request(2, 1.5, 1, 64, 16)];
    placement.update(&twice, &Capacity { side: 256, pools: PLENTY });
    let grants: Vec<_> = placement.grants().collect();
    assert_eq!(grants[0], grants[1]);
    assert_eq!((grants[0].tiles.len(), grants[0].tiles[0].size), (2, 64));
    let before = granted(&placement, &twice);
    twice.reverse();
    placement.update(&twice, &Capacity { side: 256, pools: PLENTY });
    assert_eq!(granted(&placement, &twice), before);
}

#[test]
fn keys_of_names_differ() {
    let names = ["lamp", "lamp.001", "", "lamq"];
    let mut keys: Vec<Key> = names.iter().flat_map(|name| (0..3).map(move |at| Key::of(name, at))).collect();
    keys.sort();
    keys.dedup();
    assert_eq!(keys.len(), 12);
}
