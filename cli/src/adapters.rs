//! `umbragraph adapters`: the graphics adapters of the machine, and what the pipelines that come with the command
//! become on each.
//!
//! A pipeline is planned for the profile of the adapter, as `render` does it. It is whole there, or is without features
//! whose requirements the adapter does not meet, or has errors. Nothing is drawn; a device is opened, since some
//! drivers list an adapter and give none.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use serde_json::json;
use umbragraph::diagnostic::{Diagnostics, Severity, list_of};
use umbragraph::low_level::session::Target;
use umbragraph::low_level::shader::TargetProfile;

use crate::arguments::{AdaptersArguments, AnswerFormat};
use crate::device;
use crate::session::Session;
use crate::streams::{complain, print, print_json};

/// The bundled pipelines that are planned on each adapter.
const SYSTEMS: [&str; 6] = ["mantis", "nebula", "caracal", "lore", "awsm", "umbra"];

/// The description of a graphics adapter, with the bundled pipelines planned on it.
struct Described {
    name: String,
    kind: String,
    driver: String,
    /// The parts of WebGPU's core mode that the adapter lacks.
    lacking: Vec<&'static str>,
    /// The reason why the adapter provides no device; `None` if it provides one.
    no_device: Option<String>,
    systems: Vec<System>,
}

/// The result of planning a pipeline on an adapter.
struct System {
    name: &'static str,
    /// The names of features that are off because the adapter lacks support.
    without: Vec<String>,
    /// The message of the first error; `None` if the pipeline can be planned.
    error: Option<String>,
}

/// Prints the adapters. Returns `true` if the machine has at least one.
pub(crate) fn run(arguments: &AdaptersArguments) -> bool {
    let adapters = match device::all() {
        Ok(adapters) => adapters,
        Err(diagnostic) => {
            complain(&umbragraph::diagnostic::render::human_all([&diagnostic], &Default::default()));
            return false;
        }
    };
    let mut session = Session::new(&Default::default());
    let described: Vec<Described> =
        adapters.iter().map(|(name, adapter)| describe(&mut session, name, adapter)).collect();
    match arguments.format {
        AnswerFormat::Human => print(&described.iter().map(Described::text).collect::<String>()),
        AnswerFormat::Json => {
            let adapters: Vec<_> = described.iter().map(Described::json).collect();
            print_json(&format!("{:#}\n", json!({ "adapters": adapters })));
        }
    }
    true
}

fn describe(session: &mut Session, name: &str, adapter: &wgpu::Adapter) -> Described {
    let info = adapter.get_info();
    let profile =
        TargetProfile::webgpu().on_device(&adapter.limits(), adapter.get_downlevel_capabilities().flags);
    let words = [info.driver, info.driver_info].into_iter().filter(|word| !word.is_empty());
    Described {
        name: name.to_owned(),
        kind: format!("{:?}", info.device_type),
        driver: words.collect::<Vec<_>>().join(" "),
        lacking: profile.lacking(),
        no_device: device::request(name, adapter).err().map(|diagnostic| diagnostic.message),
        systems: SYSTEMS.iter().map(|name| system(session, name, adapter)).collect(),
    }
}

fn system(session: &mut Session, name: &'static str, adapter: &wgpu::Adapter) -> System {
    let target = Target::new(format!("umbragraph:{name}.json"));
    let mut plan = |profile: TargetProfile| session.plan_aside(&target, profile);
    let first = |diagnostics: &Diagnostics| {
        let error = diagnostics.iter().find(|one| one.severity == Severity::Error);
        error.map(|error| error.message.clone())
    };
    let failed = |error| System { name, without: Vec::new(), error };
    let usual = plan(TargetProfile::webgpu());
    let Some(pipeline) = usual.as_ref().and_then(|planned| planned.report.pipeline.clone()) else {
        return failed(Some("it is not there".to_owned()));
    };
    let Some(planned) = plan(device::profile_on(&pipeline, adapter)) else { return failed(None) };
    let on = |pipeline: &umbragraph::low_level::pipeline::TypedPipeline| -> BTreeSet<String> {
        let features = pipeline.features.iter().filter(|(_, feature)| feature.is_on());
        features.map(|(name, _)| name.clone()).collect()
    };
    let left = planned.report.pipeline.as_deref().map(on).unwrap_or_default();
    let without = on(&pipeline).difference(&left).cloned().collect();
    System { name, without, error: first(&planned.diagnostics).filter(|_| planned.report.plan.is_none()) }
}

impl Described {
    fn text(&self) -> String {
        let Self { name, kind, driver, lacking, no_device, systems } = self;
        let mut text = format!("{name}\n  kind: {kind}\n");
        if !driver.is_empty() {
            let _ = writeln!(text, "  driver: {driver}");
        }
        let lacking = if lacking.is_empty() { "nothing".to_owned() } else { list_of(lacking) };
        let _ = writeln!(text, "  lacks of WebGPU's core mode: {lacking}");
        if let Some(reason) = no_device {
            let _ = writeln!(text, "  draws nothing: {reason}");
            return text;
        }
        let whole = systems.iter().filter(|system| system.without.is_empty() && system.error.is_none());
        let whole: Vec<_> = whole.map(|system| system.name).collect();
        if !whole.is_empty() {
            let _ = writeln!(text, "  draws whole: {}", list_of(whole));
        }
        for System { name, without, error } in systems {
            match error {
                Some(error) => {
                    let _ = writeln!(text, "  does not draw {name}: {error}");
                }
                None if without.is_empty() => {}
                None => {
                    let _ = writeln!(text, "  draws {name} without {}", list_of(without));
                }
            }
        }
        text
    }

    fn json(&self) -> serde_json::Value {
        let systems = self.systems.iter().map(
            |System { name, without, error }| json!({ "name": name, "without": without, "error": error }),
        );
        json!({
            "name": self.name,
            "kind": self.kind,
            "driver": self.driver,
            "lacking": self.lacking,
            "no_device": self.no_device,
            "systems": systems.collect::<Vec<_>>(),
        })
    }
}
