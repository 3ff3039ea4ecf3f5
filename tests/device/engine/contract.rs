//! The draw contract: an engine's own storage draws what the plain one draws.

use umbragraph::draw::{HostFilters, HostInterface, HostResourceKind};
use umbragraph::{Executor, Frame, Library, Options};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;

use super::meshes::{Meshes, frame, interface, plan};

const SIZE: [u32; 2] = [320, 180];

fn picture(gpu: &Gpu, instanced: bool, options: &Options) -> Picture {
    let plan = plan(instanced, options);
    let meshes = Meshes::new(gpu, instanced);
    let target = crate::common::gpu::import(gpu, &plan, "target");
    let made = Executor::new(&gpu.device, &gpu.queue, plan, Some(&meshes));
    let mut executor = made.unwrap_or_else(|error| panic!("{error}"));
    let input = frame(SIZE);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    executor
        .record(&mut encoder, &Frame::new(&input).draws(&meshes).imports(&[("target", &target)]))
        .unwrap_or_else(|error| panic!("{error}"));
    gpu.queue.submit([encoder.finish()]);
    crate::common::gpu::read(gpu, &target)
}

/// Arrays by instance, an indirect draw, a second vertex layout, bind groups of the engine's own: the same picture, of
/// lit surfaces, of shadows alone, and through the passes of a subgraph that keeps maps.
#[test]
fn an_engine_s_draws_match_plain_draws_in_awsm_cascades() {
    let Some(gpu) = gpu::device() else { return };
    let options = Options::new(SIZE[0], SIZE[1]).set("cascade_side", 1024);
    for options in [options.clone(), options.feature("cached", true).feature("contact_shadows", true)] {
        let (plain, engine) = (picture(&gpu, false, &options), picture(&gpu, true, &options));
        let differing = plain.rgba_pixels().zip(engine.rgba_pixels()).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 0, "{options:?}");
        let dark = plain.rgba_pixels().filter(|pixel| pixel[..3].iter().all(|value| *value < 90)).count();
        assert!((300..40_000).contains(&dark), "{dark} dark pixels: is there a shadow?");
    }
}

/// A host layout that does not fit is found without a device, by the name of the part that differs.
#[test]
fn storage_that_does_not_fit_is_named() {
    let stated = |name: &str, host: HostInterface, wanted: &str| {
        let text = r#"{ "format": 1, "name": "engine", "extends": "umbragraph:awsm.json",
          "derived": { "geometry": "='engine'", "instanced": "=true" },
          "geometry": { "engine": {
            "vertex": { "position": "float32x3", "normal": "float32x3", "texcoord": "float32x2" },
            "material": {
              "material": { "base_color": "vec4<f32>", "emissive": "vec3<f32>", "alpha_cutoff": "f32", "receive_shadow": "u32" },
              "base_color_texture": "texture_2d<f32>", "base_color_sampler": "sampler"
            },
            "object": { "objects": [{ "world_from_object": "mat4x4<f32>", "normal_from_object": "mat4x4<f32>", "receive_shadow": "u32" }] }
          } } }"#;
        let pipeline = Library::new().host(name, host).load_text("engine.json", text).unwrap();
        let error = pipeline.plan(&Options::new(64, 64)).expect_err(wanted).to_string();
        assert!(error.contains(wanted), "{error}");
    };
    stated("enigne", interface(true), "no host stores the geometry \"engine\"; one is stated for \"enigne\"");
    let rejected = |change: &dyn Fn(&mut HostInterface), wanted: &str| {
        let mut host = interface(true);
        change(&mut host);
        stated("engine", host, wanted);
    };
    rejected(
        &|host| {
            let HostResourceKind::Array { stride, .. } = &mut host.object[0].kind else { panic!() };
            *stride = 160;
        },
        "elements of the host's array \"objects\" lie 160 bytes apart, in lit.wgsl.jinja 144",
    );
    rejected(
        &|host| {
            let HostResourceKind::Array { members, .. } = &mut host.object[0].kind else { panic!() };
            members[2].offset = 132;
        },
        "\"objects.receive_shadow\" lies at byte 132 on the host and at byte 128",
    );
    rejected(
        &|host| host.vertex_buffers_of[0].1[1].attributes.truncate(1),
        "no vertex attribute \"texcoord\" of meshes with the properties split",
    );
    rejected(
        &|host| host.vertex_buffers[0].attributes[2].offset = 28,
        "the vertex attribute \"texcoord\" ends at byte 36 of a vertex, whose stride is 32",
    );
    rejected(
        &|host| host.filters = HostFilters::default(),
        "does not say which filters it tells apart; the pipeline draws \"casters\", \"opaque\", \"transparent\"",
    );
    rejected(
        &|host| host.filters = HostFilters::Words(vec!["opaque".to_owned(), "casters".to_owned()]),
        "the host of \"engine\" knows no filter \"transparent\"",
    );
    rejected(
        &|host| {
            host.material_layout.as_mut().unwrap().remove(1);
        },
        "the host's layout of group 2 has no binding 1, which is \"base_color_texture\"",
    );
    rejected(
        &|host| {
            let entries = host.material_layout.as_mut().unwrap();
            entries[1].ty = entries[0].ty;
        },
        "binding 1 of the host's layout of group 2 is not texture_2d<f32>",
    );
}
