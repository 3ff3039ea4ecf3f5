// Linear blend skinning: one invocation for each vertex of a draw.

// A vertex as it is modelled.
struct Vertex {
    position: vec3<f32>,
    // Two joints of 16 bits in each of the two words, the first in the low half.
    first_joints: u32,
    normal: vec3<f32>,
    last_joints: u32,
    weights: vec4<f32>,
}

struct Draw {
    vertex_count: u32,
    // Among the modelled vertices.
    first_modelled: u32,
    // In the streams.
    first_vertex: u32,
    first_joint: u32,
    joint_count: u32,
}

@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var<storage, read> modelled: array<Vertex>;
// From the space of the mesh to the world.
@group(0) @binding(2) var<storage, read> joints: array<mat4x4<f32>>;
// Vertex streams of three numbers a vertex, without padding.
@group(0) @binding(3) var<storage, read_write> positions: array<f32>;
@group(0) @binding(4) var<storage, read_write> normals: array<f32>;

fn max_of(value: vec3<f32>) -> f32 {
    let size = abs(value);
    return max(size.x, max(size.y, size.z));
}

// What turns normals with a transform: its cofactors. They exist for every transform, also one that flattens. Scaled, so
// that products neither vanish nor overflow.
fn turn_normal(transform: mat3x3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let largest = max(max_of(transform[0]), max(max_of(transform[1]), max_of(transform[2])));
    if !(largest > 0.0) {
        return normal;
    }
    let x = transform[0] / largest;
    let y = transform[1] / largest;
    let z = transform[2] / largest;
    let cofactors = mat3x3<f32>(cross(y, z), cross(z, x), cross(x, y));
    let size = max(max_of(cofactors[0]), max(max_of(cofactors[1]), max_of(cofactors[2])));
    if !(size > 0.0) {
        return normal;
    }
    // A mirrored mesh is turned inside out by its cofactors.
    return cofactors * normal * (select(1.0, -1.0, dot(cofactors[2], z) < 0.0) / size);
}

@compute @workgroup_size(64)
fn skin(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= draw.vertex_count {
        return;
    }
    let vertex = modelled[draw.first_modelled + id.x];
    let four = vec4<u32>(
        vertex.first_joints & 0xffffu, vertex.first_joints >> 16u,
        vertex.last_joints & 0xffffu, vertex.last_joints >> 16u,
    );
    var blended = mat4x4<f32>();
    for (var at = 0u; at < 4u; at += 1u) {
        if four[at] < draw.joint_count && vertex.weights[at] > 0.0 {
            blended += joints[draw.first_joint + four[at]] * vertex.weights[at];
        }
    }
    let position = (blended * vec4<f32>(vertex.position, 1.0)).xyz;
    let turned = turn_normal(mat3x3<f32>(blended[0].xyz, blended[1].xyz, blended[2].xyz), vertex.normal);
    let size = max_of(turned);
    var normal = vec3<f32>(0.0, 1.0, 0.0);
    if size > 0.0 {
        normal = normalize(turned / size);
    }
    let to = 3u * (draw.first_vertex + id.x);
    positions[to] = position.x;
    positions[to + 1u] = position.y;
    positions[to + 2u] = position.z;
    normals[to] = normal.x;
    normals[to + 1u] = normal.y;
    normals[to + 2u] = normal.z;
}
