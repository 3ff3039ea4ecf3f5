//! `umbragraph wgsl`: prints generated shaders.

use umbragraph::diagnostic::{Diagnostic, Diagnostics, codes, list_of};
use umbragraph::low_level::pipeline::{Pass, ProgramVariant, TypedPipeline, is_of};
use umbragraph::low_level::shader::{self, Emitted, ShaderModule, TargetLanguage};
use umbragraph::work::ProgramHandle;

use crate::arguments::WgslArguments;
use crate::session::Session;
use crate::streams::print_contents;

/// Prints the shaders of a pipeline or of one of its passes. Returns `true` if there were no errors.
pub(crate) fn run(arguments: &WgslArguments) -> bool {
    let mut session = Session::new(&arguments.choices.files);
    let checked = session.check(&arguments.pipeline, &arguments.choices);
    let Some(pipeline) = checked.pipeline else { return session.report() };
    let is_meant = |pass: &Pass| arguments.pass.as_ref().is_none_or(|name| is_of(&pass.name, name));
    if let Some(name) = &arguments.pass
        && !pipeline.passes.iter().any(is_meant)
        && !session.diagnostics.has_errors()
    {
        let names: Vec<&str> = pipeline.passes.iter().map(|pass| pass.name.as_str()).collect();
        unknown_name(&mut session, "pass", name, &names);
    }
    for name in arguments.properties.iter().flatten().filter(|name| !name.is_empty()) {
        let mut names: Vec<&str> =
            pipeline.geometry.values().flat_map(|geometry| &geometry.variants).map(String::as_str).collect();
        names.sort_unstable();
        if !names.contains(&name.as_str()) {
            unknown_name(&mut session, "mesh property", name, &names);
        }
    }
    // Of a pipeline with errors, the shaders of the passes that are sound are printed.
    let fine = session.report();
    session.diagnostics = Diagnostics::new();
    let mut output = Vec::new();
    for pass in pipeline.passes.iter().filter(|pass| is_meant(pass)) {
        let Some(program) = pass.work().program() else { continue };
        let template = &pipeline.program(program).template;
        for module in modules(&pipeline, program, arguments) {
            if arguments.target != TargetLanguage::Spirv {
                let axes = shader::describe(&module.axes);
                output.extend_from_slice(format!("// pass {}: {template} [{axes}]\n", pass.name).as_bytes());
            }
            if arguments.map {
                output.extend_from_slice(module.annotated(session.sources()).as_bytes());
                continue;
            }
            match module.emit(&pipeline.profile, arguments.target) {
                Ok(Emitted::Text(text)) => {
                    output.extend_from_slice(text.as_bytes());
                    output.push(b'\n');
                }
                Ok(words @ Emitted::Words(_)) => output.extend(words.to_bytes()),
                Err(diagnostic) => session.diagnostics.push(*diagnostic),
            }
        }
    }
    // What is rejected is printed as well: the lines of its errors are in it.
    for (template, axes) in pipeline.rejected.iter().filter(|_| arguments.target == TargetLanguage::Wgsl) {
        if let Some(text) = shader::generate(&session.templates, template, axes) {
            let axes = shader::describe(axes);
            output.extend_from_slice(format!("// rejected: {template} [{axes}]\n{text}\n").as_bytes());
        }
    }
    print_contents(&output);
    session.report() && fine
}

fn unknown_name(session: &mut Session, what: &str, name: &str, names: &[&str]) {
    let place = session.on_command_line(name);
    let diagnostic = Diagnostic::error(codes::UNKNOWN_PASS, place, format!("there is no {what} \"{name}\""));
    session.diagnostics.push(diagnostic.suggest(name, names.iter().copied(), None, |names| match names {
        [] => format!("this pipeline has no {what}"),
        names => format!("there are {}", list_of(names)),
    }));
}

/// Returns the distinct shader modules to print; a single one for a binary format.
fn modules<'a>(
    pipeline: &'a TypedPipeline,
    program: ProgramHandle,
    arguments: &WgslArguments,
) -> Vec<&'a ShaderModule> {
    let program = pipeline.program(program);
    let plain = Vec::new();
    let is_binary = arguments.target == TargetLanguage::Spirv;
    let properties = arguments.properties.as_ref().or(is_binary.then_some(&plain));
    let wanted: Vec<&ProgramVariant> = match properties {
        Some(names) => vec![program.variant(&names.iter().map(String::as_str).collect::<Vec<_>>())],
        None => program.variants.iter().collect(),
    };
    let mut modules: Vec<&ShaderModule> = Vec::new();
    for variant in wanted {
        if !modules.iter().any(|known| known.hash == variant.module.hash) {
            modules.push(&variant.module);
        }
    }
    modules
}
