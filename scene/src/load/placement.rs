//! Cameras and lights, where nodes of the shown scene place them.

use glam::{DMat4, DVec3};
use gltf::json::Root;
use gltf::json::camera::Type;
use gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type as LightType};
use gltf::json::validation::Checked;
use std::f32::consts::FRAC_PI_2;
use umbragraph_pipeline::frame::{Bounds, Light, LightKind, Projection};

use super::extras::ObjectExtras;
use super::limits::MAX_DISTANCE;
use super::report::Report;
use crate::codes;
use crate::light::{SceneLight, direction};
use crate::node::NodeId;
use crate::pose::Pose;
use crate::scene::Scene;
use crate::view::{SceneCamera, rotation_of};

fn shown(scene: &Scene) -> Vec<NodeId> {
    scene.order.iter().copied().filter(|id| scene.node(*id).shown).collect()
}

/// Adds the cameras of all drawn nodes to the scene. Unusable cameras are reported as errors and left out.
pub(super) fn cameras(root: &Root, scene: &mut Scene, pose: &Pose, report: &mut Report) {
    for node in shown(scene) {
        let Some(index) = root.nodes[node.index()].camera else { continue };
        let node_at = format!("/nodes/{}", node.index());
        let Some(json) = report.lookup(&root.cameras, index.value(), "camera", &format!("{node_at}/camera"))
        else {
            continue;
        };
        let at = format!("/cameras/{}", index.value());
        let Some(projection) = projection(json, &at, report) else { continue };
        let name = [&json.name, &root.nodes[node.index()].name].into_iter().flatten().next();
        let camera = SceneCamera { name: name.cloned().unwrap_or_default(), node, projection };
        let world = pose.world(node);
        let reason = match rotation_of(&world) {
            None => Some("the transform of its node leaves it no direction"),
            Some(_) => camera.placed(&world, &Bounds::EMPTY, 1.0).check(),
        };
        match reason {
            Some(reason) => {
                let help = "a camera needs a field of view above 0 and below π, 0 < near < far, and a node without a scale of 0";
                let at = if reason.contains("node") { &node_at } else { &at };
                report.error(
                    codes::BAD_CAMERA,
                    at,
                    format!("camera {} cannot be used: {reason}", index.value()),
                    help,
                );
            }
            None if is_out_of_reach(&world, &format!("camera {}", index.value()), &node_at, report) => {}
            None => scene.cameras.push(camera),
        }
    }
}

/// Reports an error and returns `true` if an object is farther than [`MAX_DISTANCE`] (in metres) from the origin along
/// an axis.
fn is_out_of_reach(world: &DMat4, noun: &str, at: &str, report: &mut Report) -> bool {
    let farthest = world.w_axis.truncate().abs().max_element();
    let is_near = farthest <= MAX_DISTANCE;
    if !is_near {
        report.error(
            codes::BAD_TRANSFORM,
            at,
            format!("{noun} stands farther than {MAX_DISTANCE:.0} metres from the origin"),
            "check the units: glTF is in metres",
        );
    }
    !is_near
}

fn projection(json: &gltf::json::Camera, at: &str, report: &mut Report) -> Option<Projection> {
    let help = "it is perspective or orthographic";
    let kind = report.known(&json.type_, &format!("{at}/type"), "the camera has an unknown type", help)?;
    let found = match kind {
        Type::Perspective => json.perspective.as_ref().map(|view| Projection::Perspective {
            vertical_fov: f64::from(view.yfov),
            near: f64::from(view.znear),
            far: view.zfar.map_or(f64::INFINITY, f64::from),
        }),
        Type::Orthographic => json.orthographic.as_ref().map(|view| Projection::Orthographic {
            half_height: f64::from(view.ymag),
            near: f64::from(view.znear),
            far: f64::from(view.zfar),
        }),
    };
    if found.is_none() {
        let message = "the camera lacks the properties of its type";
        report.error(codes::BAD_CAMERA, at, message, "add the object perspective or orthographic");
    }
    found
}

/// Adds the lights of all drawn nodes to the scene. Unusable lights are reported as errors and left out.
pub(super) fn lights(root: &Root, scene: &mut Scene, pose: &Pose, report: &mut Report) {
    let list: &[JsonLight] = root.as_ref();
    for node in shown(scene) {
        let json = &root.nodes[node.index()];
        let placed = json.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        let Some(index) = placed.map(|placed| placed.light.value()) else { continue };
        let node_at = format!("/nodes/{}", node.index());
        let light_at = format!("{node_at}/extensions/KHR_lights_punctual/light");
        let Some(light) = report.lookup(list, index, "light", &light_at) else { continue };
        let names = [&json.name, &light.name].into_iter().flatten();
        let name = names.into_iter().find(|name| !name.is_empty()).cloned();
        let at = format!("/extensions/KHR_lights_punctual/lights/{index}");
        let extras = [ObjectExtras::new(&json.extras, &node_at), ObjectExtras::new(&light.extras, &at)];
        let Some(mut light) =
            one(light, name.unwrap_or_else(|| format!("light {index}")), &extras, &at, report)
        else {
            continue;
        };
        match (direction(&pose.world(node)), light.kind) {
            (Some(direction), _) => light.direction = direction,
            (None, LightKind::Point) => {}
            (None, _) => {
                let message =
                    format!("light {:?} has no direction: its node is scaled to nothing", light.name);
                report.error(codes::BAD_LIGHT, &node_at, message, "give the node a scale that is not 0");
                continue;
            }
        }
        if is_out_of_reach(&pose.world(node), &format!("light {:?}", light.name), &node_at, report) {
            continue;
        }
        scene.lights.push(SceneLight { node, light });
    }
}

/// Reads a value from the extras of a node and of its light. The value of the node has priority.
fn stronger<T>(extras: &[ObjectExtras; 2], read: impl FnMut(&ObjectExtras) -> Option<T>) -> Option<T> {
    extras.each_ref().map(read).into_iter().flatten().next()
}

fn one(
    json: &JsonLight,
    name: String,
    extras: &[ObjectExtras; 2],
    at: &str,
    report: &mut Report,
) -> Option<Light> {
    let mut usable = true;
    let mut check = |holds: bool, property: &str, message: &str, help: &str| {
        if !holds {
            usable = false;
            report.error(
                codes::BAD_LIGHT,
                &format!("{at}/{property}"),
                format!("light {name:?}: {message}"),
                help,
            );
        }
    };
    let fine = |value: f32| value.is_finite() && value >= 0.0;
    check(
        json.color.into_iter().all(fine),
        "color",
        "its colour is negative or not finite",
        "use values from 0 to 1",
    );
    check(
        fine(json.intensity),
        "intensity",
        "its intensity is negative or not finite",
        "use candela, or lux for a directional light",
    );
    let brightness = json.color.map(|part| part * json.intensity);
    check(
        !fine(json.intensity) || !json.color.into_iter().all(fine) || brightness.into_iter().all(fine),
        "intensity",
        "its intensity times its colour is beyond what numbers of 32 bits hold",
        "use candela, or lux for a directional light",
    );
    let range_is_usable = json.range.is_none_or(|range| range.is_finite() && range > 0.0);
    check(
        range_is_usable,
        "range",
        "its range is not above zero",
        "leave the range out where there is no limit",
    );
    let kind = match &json.type_ {
        Checked::Valid(LightType::Directional) => LightKind::Directional,
        Checked::Valid(LightType::Point) => LightKind::Point,
        Checked::Valid(LightType::Spot) => {
            let cone =
                json.spot.clone().unwrap_or(gltf::json::extensions::scene::khr_lights_punctual::Spot {
                    inner_cone_angle: 0.0,
                    outer_cone_angle: std::f32::consts::FRAC_PI_4,
                });
            let (inner, outer) = (cone.inner_cone_angle, cone.outer_cone_angle);
            // π/2 as decimal text is often rounded up.
            let is_cone = inner >= 0.0 && inner < outer && outer <= FRAC_PI_2 + 1e-4;
            check(
                is_cone,
                "spot",
                "its cone is empty or wider than a half space",
                "0 ≤ innerConeAngle < outerConeAngle ≤ π/2",
            );
            LightKind::Spot { inner_angle: inner, outer_angle: outer.min(FRAC_PI_2) }
        }
        Checked::Invalid => {
            check(false, "type", "its type is unknown", "it is directional, point or spot");
            LightKind::Point
        }
    };
    let mut number = |key: &str| stronger(extras, |extras| extras.number(key, report));
    let (angular_diameter_deg, radius) = (number("angular_diameter_deg"), number("radius"));
    let priority = number("priority");
    let hardness =
        stronger(extras, |extras| extras.word("shadowHardness", &["hard", "soft", "pcss"], report));
    let mut is_on = |key: &str| stronger(extras, |extras| extras.boolean(key, report)).unwrap_or(true);
    let switches = [("cast_shadow", is_on("castShadow")), ("contact_shadow", is_on("contactShadow"))];
    let words = switches.into_iter().filter_map(|(word, is_on)| is_on.then_some(word));
    let words = words.chain(hardness.map(|at| ["hard_shadow", "soft_shadow", "pcss_shadow"][at]));
    usable.then(|| {
        let light = Light::new(name, kind)
            .direction(DVec3::NEG_Z)
            .color(json.color)
            .intensity(json.intensity)
            .range(json.range.unwrap_or(f32::INFINITY))
            .angular_diameter(angular_diameter_deg.unwrap_or(0.0).min(180.0).to_radians())
            .radius(radius.unwrap_or(0.0))
            .priority(priority.unwrap_or(1.0));
        words.fold(light, Light::property)
    })
}
