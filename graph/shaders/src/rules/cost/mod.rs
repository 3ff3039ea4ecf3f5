//! The cost of a shader: operations counted over naga's form of it, without a device.
//!
//! ```text
//! function ──walk──▶ operations, how often it calls which function, registers ──total──▶ cost of an entry point
//! ```
//!
//! Every function is counted once ([`of`]); what it calls is added where functions come together ([`total`]). The unit
//! is one scalar operation of one invocation; [`WEIGHTS`] says how many of them everything else counts for.
//!
//! It is a figure to compare variants and versions of one shader by, the same on every machine. It is no time: it knows
//! nothing of caches, bandwidth, how many invocations run at once, or what a driver's compiler removes. Both sides of a
//! branch count, since a group whose invocations disagree runs both. A loop counts as often as it runs at most, where
//! its bounds are constants or overrides at their defaults, and else [`UNKNOWN_TRIPS`] times; `unknown_loops` says how
//! many do. Registers are the most scalars alive at once, with all local variables: compilers need fewer.

mod live;
mod trips;
mod walk;

use std::collections::HashMap;
use std::hash::Hash;

pub(crate) use walk::{lines, of};

/// The assumed number of iterations of a loop with unknown bounds.
pub(crate) const UNKNOWN_TRIPS: u64 = 8;

/// The numbers of operations of a function or an entry point, per invocation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Operations {
    /// Scalar operations: a `vec3f` multiplication counts as 3. Division, square root and similar functions count as 4
    /// per scalar, `pow` as 8.
    pub arithmetic: u64,
    /// Scalars read from uniform, storage and workgroup memory.
    pub reads: u64,
    /// Texels read without a sampler.
    pub texture_reads: u64,
    /// Texture samples and gathers without a depth comparison.
    pub samples: u64,
    /// Texture samples and gathers with a depth comparison.
    pub comparisons: u64,
    /// Scalars written to storage and workgroup memory, and channels written to storage textures.
    pub writes: u64,
    /// Atomic operations on buffers, workgroup memory and textures.
    pub atomics: u64,
    /// Executed branches (`if`, `switch`) and `break if` conditions.
    pub branches: u64,
    /// Executed loops whose number of iterations is unknown. Their bodies count as if they ran 8 times.
    pub unknown_loops: u64,
}

/// A kind of operation: its name, the cost of one in scalar operations, and a function that returns the number of them.
pub type Weight = (&'static str, u64, fn(&Operations) -> u64);

/// The kinds of operations, with the cost of each in scalar operations.
pub const WEIGHTS: [Weight; 8] = [
    ("arithmetic", 1, |each| each.arithmetic),
    ("reads", 2, |each| each.reads),
    ("texture_reads", 16, |each| each.texture_reads),
    ("samples", 32, |each| each.samples),
    ("comparisons", 32, |each| each.comparisons),
    ("writes", 8, |each| each.writes),
    ("atomics", 32, |each| each.atomics),
    ("branches", 4, |each| each.branches),
];

/// The cost of one invocation of an entry point, including all called functions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Cost {
    /// The weighted sum of all operations, in scalar operations.
    pub total: u64,
    /// The number of operations of each kind.
    #[serde(flatten)]
    pub operations: Operations,
    /// The maximum number of scalars that are live at once, including all local variables. Compilers usually need fewer
    /// registers.
    pub registers: u64,
}

/// The operations of a function without its callees. `K` is the key type that identifies functions.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Spent<K> {
    pub(crate) operations: Operations,
    pub(crate) registers: u64,
    pub(crate) calls: Vec<Call<K>>,
}

/// A call in a function's body: the called function, and the number of executions.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Call<K> {
    pub(crate) callee: K,
    pub(crate) times: u64,
    /// The number of scalars in the caller that are live during the call.
    pub(crate) live: u64,
}

impl Operations {
    fn all(&mut self) -> [&mut u64; 9] {
        let Self {
            arithmetic,
            reads,
            texture_reads,
            samples,
            comparisons,
            writes,
            atomics,
            branches,
            unknown_loops,
        } = self;
        [arithmetic, reads, texture_reads, samples, comparisons, writes, atomics, branches, unknown_loops]
    }

    /// Adds the operations of other code that is executed `times` times.
    fn add(&mut self, mut others: Self, times: u64) {
        for (own, other) in self.all().into_iter().zip(others.all()) {
            *own = own.saturating_add(other.saturating_mul(times));
        }
    }

    fn weighted(&self) -> u64 {
        WEIGHTS.iter().fold(0, |sum, (_, weight, of)| sum.saturating_add(weight.saturating_mul(of(self))))
    }
}

impl<K> Spent<K> {
    /// Converts the keys of called functions with `id`. Calls of functions for which `id` returns `None` are left out.
    pub(crate) fn by<L>(&self, id: impl Fn(&K) -> Option<L>) -> Spent<L> {
        let call =
            |call: &Call<K>| Some(Call { callee: id(&call.callee)?, times: call.times, live: call.live });
        let calls = self.calls.iter().filter_map(call).collect();
        Spent { operations: self.operations, registers: self.registers, calls }
    }
}

/// Returns the cost of the entry point with the key `entry`. `functions` holds the operations of all functions of its
/// module.
pub(crate) fn total<'f, K: Eq + Hash>(entry: &'f K, functions: &HashMap<&'f K, &'f Spent<K>>) -> Cost {
    let (operations, registers) = sum(entry, functions, &mut HashMap::new());
    Cost { total: operations.weighted(), operations, registers }
}

fn sum<'f, K: Eq + Hash>(
    function: &'f K,
    functions: &HashMap<&'f K, &'f Spent<K>>,
    known: &mut HashMap<&'f K, (Operations, u64)>,
) -> (Operations, u64) {
    if let Some(known) = known.get(function) {
        return *known;
    }
    // WGSL has no recursion; a circle would count once.
    known.insert(function, Default::default());
    let Some(spent) = functions.get(function) else { return Default::default() };
    let (mut operations, mut registers) = (spent.operations, spent.registers);
    for Call { callee, times, live } in &spent.calls {
        let (inner, alive) = sum(callee, functions, known);
        operations.add(inner, *times);
        registers = registers.max(live.saturating_add(alive));
    }
    known.insert(function, (operations, registers));
    (operations, registers)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::{Cost, Spent};

    fn cost(text: &str) -> Cost {
        let module = naga::front::wgsl::parse_str(text).expect("WGSL");
        let flags = naga::valid::ValidationFlags::all();
        let info = naga::valid::Validator::new(flags, naga::valid::Capabilities::all());
        let info = { info }.validate(&module).expect("valid WGSL");
        let mut all: Vec<(String, Spent<String>)> = module
            .functions
            .iter()
            .map(|(handle, each)| {
                (each.name.clone().unwrap_or_default(), super::of(&module, each, &info[handle]))
            })
            .collect();
        let entry = &module.entry_points[0];
        all.push((entry.name.clone(), super::of(&module, &entry.function, info.get_entry_point(0))));
        let functions: HashMap<_, _> = all.iter().map(|(name, spent)| (name, spent)).collect();
        super::total(&entry.name, &functions)
    }

    fn fragment(body: &str) -> Cost {
        cost(&format!(
            "struct Block {{ matrix: mat4x4f, sun: vec3f, count: u32 }}
             @group(0) @binding(0) var<uniform> block: Block;
             @group(0) @binding(1) var map: texture_depth_2d;
             @group(0) @binding(2) var compare: sampler_comparison;
             @group(0) @binding(3) var image: texture_2d<f32>;
             @group(0) @binding(4) var linear: sampler;
             @group(0) @binding(5) var<storage, read_write> list: array<f32>;
             override taps: u32 = 5;
             fn tap(at: vec2f) -> f32 {{ return textureSampleCompareLevel(map, compare, at, 0.5); }}
             fn reset(at: ptr<function, u32>) {{ *at = 0u; }}
             @fragment fn shade(@location(0) at: vec2f) -> @location(0) vec4f {{
                 var sum = 0.0;
                 {body}
                 return vec4f(sum);
             }}"
        ))
    }

    #[test]
    fn operations_are_counted_by_scalars() {
        let found = fragment("let x = at * 2.0; sum = x.x / x.y;").operations;
        assert_eq!((found.arithmetic, found.reads, found.branches), (2 + 4, 0, 0));
        let found = fragment("sum = dot(block.sun, block.sun);").operations;
        assert_eq!((found.arithmetic, found.reads), (6, 6));
        let found = fragment("sum = (block.matrix * vec4f(at, at)).x;").operations;
        assert_eq!((found.arithmetic, found.reads), (32, 16));
        let found =
            fragment("list[1] = textureSample(image, linear, at).x + textureLoad(image, vec2i(1), 0).x;");
        let found = found.operations;
        assert_eq!((found.samples, found.texture_reads, found.writes), (1, 1, 1));
    }

    #[test]
    fn loops_count_as_often_as_they_run() {
        let taps = |body: &str| {
            let found = fragment(body).operations;
            (found.comparisons, found.unknown_loops)
        };
        for (body, expected) in [
            ("for (var i = 0u; i < 4u; i++) { sum += tap(at); }", (4, 0)),
            ("for (var i = 0u; i <= 4u; i++) { sum += tap(at); }", (5, 0)),
            ("for (var i = 8; i > 0; i -= 3) { sum += tap(at); }", (3, 0)),
            ("for (var i = 0u; 6u > i; i += 2u) { for (var j = 1; j < 3; j++) { sum += tap(at); } }", (6, 0)),
            ("for (var i = 0u; i < taps; i++) { sum += tap(at); }", (5, 0)),
            ("for (var i = 0u; i < min(block.count, 3u); i++) { sum += tap(at); }", (3, 0)),
            ("var i = 2u; while i < 4u { sum += tap(at); i++; }", (8, 1)),
            ("for (var i = 0u; i < block.count; i++) { sum += tap(at); }", (8, 1)),
            ("for (var i = 0u; i < 4u; i++) { if sum > 9.0 { i = 2u; } sum += tap(at); }", (8, 1)),
            ("for (var i = 4u; i < 4u; i++) { sum += tap(at); }", (0, 0)),
            ("var i: u32; for (; i < 4u; i++) { sum += tap(at); }", (4, 0)),
            (
                "var i = 0u; if at.x > 1.0 { i = 3u; } else { for (; i < 4u; i++) { sum += tap(at); } }",
                (4, 0),
            ),
            ("var i = 0u; if at.x > 1.0 { i = 3u; } for (; i < 4u; i++) { sum += tap(at); }", (8, 1)),
            ("var i = 3u; reset(&i); for (; i < 4u; i++) { sum += tap(at); }", (8, 1)),
            ("for (var i = min(block.count, 3u); i < 4u; i++) { sum += tap(at); }", (8, 1)),
            ("for (var i = 10u; i > min(block.count, 6u); i--) { sum += tap(at); }", (8, 1)),
            ("for (var i = 0u; i < 16u; i += min(block.count, 8u)) { sum += tap(at); }", (8, 1)),
            ("for (var i = 0u; i < u32(min(i32(block.count), -1)); i++) { sum += tap(at); }", (8, 1)),
        ] {
            assert_eq!(taps(body), expected, "{body}");
        }
    }

    #[test]
    fn branches_count_whole_and_registers_at_the_worst_place() {
        let found = fragment("if at.x > 0.0 { sum = tap(at); } else { sum = tap(at.yx); }");
        assert_eq!((found.operations.comparisons, found.operations.branches), (2, 1));
        let few = fragment("sum = at.x + 1.0;").registers;
        let more =
            fragment("let a = sin(at); let b = cos(at); let c = tan(at); sum = dot(a, b) + c.x + tap(c);")
                .registers;
        // A variable with a vector made of it; the variable, three vectors and the one that the last is made of.
        assert_eq!((few, more), (1 + 1 + 4, 1 + 3 * 2 + 2));
        let weighted = fragment("sum = tap(at);");
        assert_eq!(weighted.total, 32 + weighted.operations.arithmetic);
    }
}
