//! The built-in functions of WGSL, each with its signature and a line about its value.
//!
//! `T` stands for the types that the function takes: usually a number, or a vector of numbers, in which case it works
//! per component. Source: the WGSL specification, sections 17.3 to 17.13.

/// A built-in function.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// The name of the function.
    pub name: &'static str,
    /// The parameters and the type of the value.
    pub signature: &'static str,
    /// The value in a phrase.
    pub about: &'static str,
}

/// Returns the built-in function of a name.
pub fn builtin(name: &str) -> Option<Builtin> {
    all().find(|one| one.name == name)
}

impl Builtin {
    /// The names of the parameters, as they stand between the parentheses of a call.
    pub fn parameters(&self) -> String {
        let list = self.signature.split(" ->").next().unwrap_or_default();
        let list = list.strip_prefix('(').and_then(|list| list.strip_suffix(')')).unwrap_or_default();
        // A comma within the brackets of a type stands before no colon of its own.
        let names = list.split(", ").filter_map(|one| Some(one.split_once(": ")?.0));
        names.collect::<Vec<_>>().join(", ")
    }
}

/// All built-in functions.
pub fn all() -> impl Iterator<Item = Builtin> {
    let mut lines = TABLE.lines();
    std::iter::from_fn(move || {
        let (call, about) = (lines.next()?, lines.next()?.trim_start());
        let (name, _) = call.split_once('(')?;
        Some(Builtin { name, signature: call.get(name.len()..)?, about })
    })
}

const TABLE: &str = "\
abs(e: T) -> T
  absolute value
acos(e: T) -> T
  inverse cosine in radians, from 0 to π
acosh(e: T) -> T
  inverse hyperbolic cosine
all(e: vecN<bool>) -> bool
  true if every component is true
any(e: vecN<bool>) -> bool
  true if a component is true
arrayLength(p: ptr<storage, array<E>>) -> u32
  number of elements of a runtime-sized array
asin(e: T) -> T
  inverse sine in radians, from -π/2 to π/2
asinh(e: T) -> T
  inverse hyperbolic sine
atan(e: T) -> T
  inverse tangent in radians, from -π/2 to π/2
atan2(y: T, x: T) -> T
  angle of the point (x, y) in radians, from -π to π
atanh(e: T) -> T
  inverse hyperbolic tangent
atomicAdd(p: ptr<atomic<T>>, v: T) -> T
  adds v; the value before
atomicAnd(p: ptr<atomic<T>>, v: T) -> T
  bitwise and with v; the value before
atomicCompareExchangeWeak(p: ptr<atomic<T>>, compare: T, v: T) -> { old_value: T, exchanged: bool }
  stores v if the value is compare; may fail at random
atomicExchange(p: ptr<atomic<T>>, v: T) -> T
  stores v; the value before
atomicLoad(p: ptr<atomic<T>>) -> T
  value of an atomic
atomicMax(p: ptr<atomic<T>>, v: T) -> T
  stores the larger value; the value before
atomicMin(p: ptr<atomic<T>>, v: T) -> T
  stores the smaller value; the value before
atomicOr(p: ptr<atomic<T>>, v: T) -> T
  bitwise or with v; the value before
atomicStore(p: ptr<atomic<T>>, v: T)
  stores v
atomicSub(p: ptr<atomic<T>>, v: T) -> T
  subtracts v; the value before
atomicXor(p: ptr<atomic<T>>, v: T) -> T
  bitwise exclusive or with v; the value before
ceil(e: T) -> T
  smallest whole number that is not less
clamp(e: T, low: T, high: T) -> T
  min(max(e, low), high)
cos(e: T) -> T
  cosine of an angle in radians
cosh(e: T) -> T
  hyperbolic cosine
countLeadingZeros(e: T) -> T
  number of zero bits before the highest one
countOneBits(e: T) -> T
  number of one bits
countTrailingZeros(e: T) -> T
  number of zero bits after the lowest one
cross(a: vec3<T>, b: vec3<T>) -> vec3<T>
  cross product
degrees(e: T) -> T
  radians as degrees
determinant(m: matNxN<T>) -> T
  determinant
distance(a: T, b: T) -> f32
  length of a - b
dot(a: vecN<T>, b: vecN<T>) -> T
  dot product
dot4I8Packed(a: u32, b: u32) -> i32
  dot product of four signed bytes
dot4U8Packed(a: u32, b: u32) -> u32
  dot product of four unsigned bytes
dpdx(e: T) -> T
  derivative along x in the window; fragment stage, uniform control flow
dpdxCoarse(e: T) -> T
  derivative along x, the same within a quad or finer; fragment stage
dpdxFine(e: T) -> T
  derivative along x between neighbors; fragment stage
dpdy(e: T) -> T
  derivative along y in the window; fragment stage, uniform control flow
dpdyCoarse(e: T) -> T
  derivative along y, the same within a quad or finer; fragment stage
dpdyFine(e: T) -> T
  derivative along y between neighbors; fragment stage
exp(e: T) -> T
  e to the power of the argument
exp2(e: T) -> T
  2 to the power of the argument
extractBits(e: T, offset: u32, count: u32) -> T
  count bits from offset on, with sign for signed integers
faceForward(n: vecN<T>, i: vecN<T>, reference: vecN<T>) -> vecN<T>
  n if dot(reference, i) is negative, else -n
firstLeadingBit(e: T) -> T
  index of the highest one bit; -1 without one
firstTrailingBit(e: T) -> T
  index of the lowest one bit; -1 without one
floor(e: T) -> T
  largest whole number that is not greater
fma(a: T, b: T, c: T) -> T
  a * b + c, which may be rounded once
fract(e: T) -> T
  e - floor(e)
frexp(e: T) -> { fract: T, exp: I }
  fraction from 0.5 to 1 and power of 2
fwidth(e: T) -> T
  abs(dpdx(e)) + abs(dpdy(e)); fragment stage, uniform control flow
fwidthCoarse(e: T) -> T
  abs(dpdxCoarse(e)) + abs(dpdyCoarse(e)); fragment stage
fwidthFine(e: T) -> T
  abs(dpdxFine(e)) + abs(dpdyFine(e)); fragment stage
insertBits(e: T, bits: T, offset: u32, count: u32) -> T
  e with count bits from offset on replaced
inverseSqrt(e: T) -> T
  1 / sqrt(e)
ldexp(e: T, exponent: I) -> T
  e times 2 to the power of exponent
length(e: vecN<T>) -> T
  length
log(e: T) -> T
  natural logarithm
log2(e: T) -> T
  logarithm to base 2
max(a: T, b: T) -> T
  larger value
min(a: T, b: T) -> T
  smaller value
mix(a: T, b: T, t: T) -> T
  a * (1 - t) + b * t
modf(e: T) -> { fract: T, whole: T }
  fraction and whole number, both with the sign of e
normalize(e: vecN<T>) -> vecN<T>
  vector of length 1 in the same direction
pack2x16float(e: vec2<f32>) -> u32
  two half floats as bits
pack2x16snorm(e: vec2<f32>) -> u32
  two numbers from -1 to 1 as signed 16-bit integers
pack2x16unorm(e: vec2<f32>) -> u32
  two numbers from 0 to 1 as unsigned 16-bit integers
pack4x8snorm(e: vec4<f32>) -> u32
  four numbers from -1 to 1 as signed bytes
pack4x8unorm(e: vec4<f32>) -> u32
  four numbers from 0 to 1 as unsigned bytes
pow(base: T, exponent: T) -> T
  base to the power of exponent; base must not be negative
quantizeToF16(e: T) -> T
  value rounded to a half float
radians(e: T) -> T
  degrees as radians
reflect(i: vecN<T>, n: vecN<T>) -> vecN<T>
  i mirrored at a surface with the unit normal n
refract(i: vecN<T>, n: vecN<T>, ratio: T) -> vecN<T>
  i refracted at a surface with the unit normal n; 0 for total reflection
reverseBits(e: T) -> T
  bits in reverse order
round(e: T) -> T
  nearest whole number; ties to the even one
saturate(e: T) -> T
  clamp(e, 0, 1)
select(no: T, yes: T, condition: bool) -> T
  yes if condition is true, else no; both are evaluated
sign(e: T) -> T
  1, 0 or -1
sin(e: T) -> T
  sine of an angle in radians
sinh(e: T) -> T
  hyperbolic sine
smoothstep(low: T, high: T, x: T) -> T
  0 below low, 1 above high, and a smooth curve between
sqrt(e: T) -> T
  square root
step(edge: T, x: T) -> T
  1 if edge <= x, else 0
storageBarrier()
  waits for the workgroup, with its storage buffers; compute stage, uniform control flow
tan(e: T) -> T
  tangent of an angle in radians
tanh(e: T) -> T
  hyperbolic tangent
textureDimensions(t: texture, level: u32 = 0) -> u32 or vecN<u32>
  size in texels
textureGather(component: u32, t: texture, s: sampler, coords: vecN<f32>) -> vec4<T>
  one component of the four texels that a linear filter reads
textureGatherCompare(t: texture_depth, s: sampler_comparison, coords: vecN<f32>, reference: f32) -> vec4<f32>
  comparisons with the four texels that a linear filter reads
textureLoad(t: texture, coords: vecN<u32>, level: u32) -> vec4<T>
  one texel, without a sampler
textureNumLayers(t: texture_array) -> u32
  number of layers
textureNumLevels(t: texture) -> u32
  number of mip levels
textureNumSamples(t: texture_multisampled) -> u32
  number of samples of a texel
textureSample(t: texture, s: sampler, coords: vecN<f32>) -> vec4<f32>
  filtered texel, mip level by derivatives; fragment stage, uniform control flow
textureSampleBaseClampToEdge(t: texture_2d<f32>, s: sampler, coords: vec2<f32>) -> vec4<f32>
  filtered texel of level 0, clamped to the edge
textureSampleBias(t: texture, s: sampler, coords: vecN<f32>, bias: f32) -> vec4<f32>
  filtered texel, with bias added to the mip level; fragment stage
textureSampleCompare(t: texture_depth, s: sampler_comparison, coords: vecN<f32>, reference: f32) -> f32
  filtered comparisons; fragment stage, uniform control flow
textureSampleCompareLevel(t: texture_depth, s: sampler_comparison, coords: vecN<f32>, reference: f32) -> f32
  filtered comparisons with level 0; any stage
textureSampleGrad(t: texture, s: sampler, coords: vecN<f32>, ddx: vecN<f32>, ddy: vecN<f32>) -> vec4<f32>
  filtered texel, mip level by the given derivatives
textureSampleLevel(t: texture, s: sampler, coords: vecN<f32>, level: f32) -> vec4<f32>
  filtered texel of a mip level; any stage
textureStore(t: texture_storage, coords: vecN<u32>, value: vec4<T>)
  writes one texel
transpose(m: matCxR<T>) -> matRxC<T>
  transposed matrix
trunc(e: T) -> T
  whole number toward 0
unpack2x16float(e: u32) -> vec2<f32>
  two half floats from bits
unpack2x16snorm(e: u32) -> vec2<f32>
  two numbers from -1 to 1 from signed 16-bit integers
unpack2x16unorm(e: u32) -> vec2<f32>
  two numbers from 0 to 1 from unsigned 16-bit integers
unpack4x8snorm(e: u32) -> vec4<f32>
  four numbers from -1 to 1 from signed bytes
unpack4x8unorm(e: u32) -> vec4<f32>
  four numbers from 0 to 1 from unsigned bytes
workgroupBarrier()
  waits for the workgroup, with its workgroup variables; compute stage, uniform control flow
workgroupUniformLoad(p: ptr<workgroup, T>) -> T
  value of a workgroup variable, the same for the workgroup; waits like workgroupBarrier";

#[cfg(test)]
mod tests {
    use super::*;
    use naga::keywords::wgsl::BUILTIN_IDENTIFIERS;

    #[test]
    fn each_function_is_one_of_wgsl_with_a_line() {
        let names: Vec<&str> = all().map(|one| one.name).collect();
        assert_eq!(names.len() * 2, TABLE.lines().count());
        assert!(names.is_sorted_by(|a, b| a < b), "{names:?}");
        assert_eq!(builtin("atomicAdd").map(|one| one.parameters()).as_deref(), Some("p, v"));
        assert_eq!(builtin("arrayLength").map(|one| one.parameters()).as_deref(), Some("p"));
        assert_eq!(builtin("workgroupBarrier").map(|one| one.parameters()).as_deref(), Some(""));
        for name in names {
            assert!(BUILTIN_IDENTIFIERS.contains(&name), "{name}");
            // A call with nothing is wrong in its arguments, and no unknown name.
            let error = naga::front::wgsl::parse_str(&format!("fn f() {{ let x = {name}(); }}"));
            let message = error.map_or_else(|error| error.message().to_owned(), |_| String::new());
            assert!(!message.contains("no definition in scope"), "{name}: {message}");
        }
    }
}
