//! The `umbragraph` command.
//!
//! Exit status: 0 if all is well, 1 if there are errors among the diagnostics or output is lost, 2 if the command line
//! cannot be understood.

#![warn(clippy::print_stdout, clippy::print_stderr)]

#[cfg(feature = "gpu")]
mod adapters;
mod annotations;
#[cfg(feature = "score")]
mod answer;
mod arguments;
mod axes;
mod bar;
mod budgets;
mod cache;
mod check;
mod codes;
#[cfg(feature = "gpu")]
mod device;
mod diff;
mod fmt;
mod graph;
#[cfg(feature = "gpu")]
mod interrupt;
mod junit;
mod lock;
#[cfg(feature = "lsp")]
mod lsp;
mod measured;
mod mend;
mod new;
mod observed;
mod overrides;
mod parts;
mod permutations;
mod plan;
#[cfg(feature = "gpu")]
mod progress;
mod read;
mod reference;
mod remarks;
#[cfg(feature = "gpu")]
mod render;
mod replace;
mod schema;
#[cfg(feature = "score")]
mod score;
mod session;
#[cfg(feature = "score")]
mod shadow_term;
mod show;
mod streams;
#[cfg(feature = "gpu")]
mod test;
#[cfg(feature = "score")]
mod tune;
mod validator;
mod variants;
mod view;
mod watch;
mod wgsl;
mod why;

use std::process::ExitCode;

use arguments::{Arguments, Command};

fn main() -> ExitCode {
    silence_device_selection();
    let arguments = match Arguments::of_process() {
        Ok(arguments) => arguments,
        Err(error) => {
            let text = error.render().to_string();
            if error.use_stderr() {
                streams::complain(&text);
                return ExitCode::from(2);
            }
            streams::print(&text);
            return if streams::is_lost() { ExitCode::FAILURE } else { ExitCode::SUCCESS };
        }
    };
    let fine = match arguments.command {
        Command::New(arguments) => new::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Watch(arguments) => watch::run(&arguments),
        Command::View(arguments) => return view::run(&arguments),
        Command::Permutations(arguments) => permutations::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Why(arguments) => why::run(&arguments),
        Command::Graph(arguments) => graph::run(&arguments),
        Command::Diff(arguments) => diff::run(&arguments),
        Command::Wgsl(arguments) => wgsl::run(&arguments),
        Command::Reference(arguments) => reference::run(&arguments),
        Command::Show(arguments) => show::run(&arguments),
        Command::Fmt(arguments) => fmt::run(&arguments),
        Command::Schema(arguments) => schema::run(&arguments),
        #[cfg(feature = "lsp")]
        Command::Lsp(arguments) => lsp::run(&arguments),
        #[cfg(feature = "gpu")]
        Command::Adapters(arguments) => adapters::run(&arguments),
        #[cfg(feature = "gpu")]
        Command::Render(arguments) => render::run(arguments),
        #[cfg(feature = "gpu")]
        Command::Test(arguments) => test::run(&arguments),
        #[cfg(feature = "score")]
        Command::Score(arguments) => score::run(&arguments),
        #[cfg(feature = "score")]
        Command::Tune(arguments) => tune::run(&arguments),
    };
    if fine && !streams::is_lost() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Silences two drivers. Disables Mesa's device selection layer if there is no display, since it prints errors before
/// every picture. Lowers EGL's log level, unless `EGL_LOG_LEVEL` is set.
#[cfg(all(feature = "gpu", target_os = "linux"))]
#[expect(unsafe_code, reason = "see the proof at the place")]
fn silence_device_selection() {
    let is_unset = |name: &&str| std::env::var_os(name).is_none();
    let has_no_display = ["XDG_RUNTIME_DIR", "WAYLAND_DISPLAY", "DISPLAY"].iter().all(is_unset);
    let selection = Some(("NODEVICE_SELECT", "1")).filter(|_| has_no_display);
    let egl = Some(("EGL_LOG_LEVEL", "fatal")).filter(|(name, _)| is_unset(name));
    for (name, value) in selection.into_iter().chain(egl) {
        // SAFETY: the environment may not be changed while another thread reads it; this is the first statement of
        // `main`, before any thread is started.
        unsafe { std::env::set_var(name, value) };
    }
}

#[cfg(not(all(feature = "gpu", target_os = "linux")))]
fn silence_device_selection() {}
