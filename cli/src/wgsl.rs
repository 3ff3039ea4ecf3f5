//! `umbragraph wgsl`

use umbragraph::diagnostic::{Diagnostic, codes, did_you_mean};
use umbragraph::shader;
use umbragraph::source::Span;
use umbragraph::work::{Draw, Work};

use crate::arguments::WgslArguments;
use crate::session::Session;

/// Prints the shaders of a pipeline, or of one of its passes; whether there were no errors.
pub(crate) fn run(arguments: &WgslArguments) -> bool {
    let mut session = Session::new(arguments.choices.templates.as_deref());
    let checked = session.check(&arguments.pipeline, &arguments.choices);
    let Some(pipeline) = checked.pipeline else { return session.report() };
    if let Some(name) = &arguments.pass
        && pipeline.find_pass(name).is_none()
        && !session.findings.has_errors()
    {
        let file = session.sources.add("<command line>", name.as_str());
        let names: Vec<&str> = pipeline.passes.iter().map(|pass| pass.name.as_str()).collect();
        let help = did_you_mean(name, names.iter().copied())
            .map_or_else(|| format!("the passes are {}", names.join(", ")), |meant| format!("did you mean \"{meant}\"?"));
        let place = Span::new(file, 0..name.len());
        session.findings.push(Diagnostic::error(codes::UNKNOWN_PASS, place, format!("there is no pass \"{name}\"")).help(help));
    }
    if !session.report() {
        return false;
    }
    let wanted = pipeline.passes.iter().filter(|pass| arguments.pass.as_ref().is_none_or(|name| *name == pass.name));
    for pass in wanted {
        let program = match &pass.work {
            Work::Render(render) => match &render.draw {
                Draw::Fullscreen { program, .. } => *program,
                Draw::Scene(scene) => scene.program,
            },
            Work::Compute(compute) => compute.program,
            Work::Host(_) | Work::Copy(_) => continue,
        };
        let program = pipeline.program(program);
        let mut seen = Vec::new();
        for variant in &program.variants {
            if seen.contains(&variant.module.hash) {
                continue;
            }
            seen.push(variant.module.hash);
            println!("// pass {}: {} [{}]", pass.name, program.template, shader::describe(&variant.module.axes));
            println!("{}", variant.module.wgsl);
        }
    }
    true
}
