//! The project's own commands: `cargo xtask demo`, `test`, `scenes`, `gallery`, `cameras`, `colors`,
//! `figures`, `drivers`, `validate`, `integrations`, `view`, `soak`, `fuzz`, `mutants` and `web`.
//!
//! They work on a fresh clone with nothing but cargo: other tools are installed if possible, and named otherwise. There
//! are no dependencies, so that the command itself builds in a second.
//!
//! Exit status: 0 for success, 1 if a step failed, 2 for an invalid command line.

mod adapter;
mod cameras;
mod colors;
mod demo;
mod distribution;
mod driver_search;
mod drivers;
mod figures;
mod fuzz;
mod gallery;
mod integrations;
mod job;
mod mutants;
mod process;
mod scenes;
mod skips;
mod soak;
mod steps;
mod summary;
mod test;
mod toolchain;
mod view;
mod web;

use std::process::ExitCode;

const HELP: &str = "\
The project's own commands.

usage: cargo xtask COMMAND

  demo   render the pipeline `umbra` on the project's own scene to target/demo/courtyard.png
  test   check formatting and lints, run all tests and doc tests, build the documentation
  scenes [--check]
         write the scenes in examples/scenes again, or compare them with what their programs write
  gallery
         render examples/gallery/ again: what each pipeline makes of each scene that suits it, in labelled sheets
  cameras [--seed N]
         print the worst errors and scores of each system and the flagship over 20 random cameras, scene by scene
  colors
         print how much the colors of the flagship differ from traced paths, scene by scene
  figures [TEXT] [--gpu]
         run the benches whose tables stand in docs/, all or those whose command contains the text, and write the tables
         again, with the machine; --gpu takes those for real hardware, too
  drivers [--quick] [--only PIPELINE] [--minutes N]
         render the six systems with every preset, debug view and scene, and the lessons, on every driver of the machine
         (lavapipe, SwiftShader, OpenGL, GPUs), installing those that are missing, and write docs/drivers.md: what each draws,
         and how its pixels and shadows differ. Pictures are kept in target/drivers: a run goes on where the last one ended.
         --only takes one pipeline or `lessons`, --minutes ends early, --quick takes the defaults on one scene
  validate [--all]
         draw two pipelines, or all with every scene, preset and debug view, under Vulkan's validation layer,
         synchronisation included, and count its messages
  integrations [NAME]
         build and test the packages that adopt the module in an engine (bevy) or a window (egui, and the viewer), run the
         CI job of the guide as it is written (ci), and test the language server with a library of Visual Studio Code's
         client (editor; wants npm), all or one; an engine takes half an hour to build on two cores, and wants a newer Rust, which rustup installs
  view [ARGUMENT...]
         build the live viewer and run it, without arguments on `umbra` and the project's own scene; see docs/viewer.md
  soak [--seconds N] [--cases N] [--seed N]
         run all tests of random cases with fresh seeds, N times as many cases as in ordinary tests (10), for N seconds
         or once; and what is too long for ordinary tests
  fuzz [--minutes N] [--target NAME] [--page]
         try random inputs of all that the module reads, for a minute or N, and print those that fail; a run goes on where
         the last one ended, and a target whose files changed begins again. --page writes the counts into docs/trust.md, and
         tries nothing more without --minutes
  mutants [--sample N] [--seed N] [--jobs N] [--in NAME] [--rust]
         plant faults in the shader templates, all or N of them, and say which the reference pictures do not show;
         NAME may be several parts of names with commas between, each with a line: lit.wgsl.jinja:83;
         with --rust in node kinds, scenes and engine, by cargo-mutants
  web [--test] [--serve]
         build the page for browsers in target/web/site; --test compares what a browser draws and says with the command's,
         --serve opens the page at http://127.0.0.1:8080
  help   print this

demo and test need a graphics adapter. On Linux without a Vulkan driver they install Mesa's software driver (Debian and
Ubuntu, with apt and the rights to do so) or say what to install.

environment:
  UMBRAGRAPH_REQUIRE_GPU=1   a test that finds no adapter fails instead of being skipped
  UMBRAGRAPH_ADAPTER=TEXT    the adapter whose name contains the text
  UMBRAGRAPH_BLESS=1         accept pictures that differ from their references
  UMBRAGRAPH_TRUTH=FOLDER    the ray-traced truth, in place of ../shared/truth
  UMBRAGRAPH_BROWSER=FILE    the browser that `web --test` drives, in place of chromium
  UMBRAGRAPH_REQUIRE_BROWSER=1
                             `web --test` fails where no browser is installed
  UMBRAGRAPH_VIEW_SECONDS=N  the time of random input in the viewer's test, in place of 60
  UMBRAGRAPH_VIEW_PATIENCE=N the seconds that the viewer's test waits for an answer, in place of 90
  UMBRAGRAPH_VIEW_EDITS=N    the number of random edits in the viewer's test, in place of 20
  UMBRAGRAPH_COMMAND=FILE    the command that the viewer's test compares with, in place of building it
  UMBRAGRAPH_SEED=N          another seed for tests of random cases, and
  UMBRAGRAPH_TIMES=N         N times as many of them: what `soak` sets and prints
";

/// A subcommand with its options.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Command {
    Demo,
    Test,
    Scenes { check: bool },
    Gallery,
    Cameras { seed: u64 },
    Colors,
    Figures(figures::Options),
    Drivers(drivers::Options),
    Validate { all: bool },
    Integrations { only: Option<String> },
    View(Vec<String>),
    Soak(soak::Options),
    Fuzz(fuzz::Options),
    Mutants(mutants::Options),
    Web(web::Options),
    Help,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let command = match parse(&arguments) {
        Ok(command) => command,
        Err(message) => {
            eprintln!("xtask: {message}\n\n{HELP}");
            return ExitCode::from(2);
        }
    };
    let fine = run(command).unwrap_or_else(|message| {
        eprintln!("{message}");
        false
    });
    if fine { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs a command. Returns `true` if it succeeded; the command itself has printed its failures.
///
/// # Errors
/// A failure that the command has not printed.
fn run(command: Command) -> Result<bool, String> {
    match command {
        Command::Demo => demo::run(),
        Command::Test => test::run(),
        Command::Scenes { check } => scenes::run(check),
        Command::Gallery => gallery::run(),
        Command::Cameras { seed } => cameras::run(seed),
        Command::Colors => colors::run(),
        Command::Figures(options) => figures::run(&options),
        Command::Drivers(options) => drivers::run(&options),
        Command::Validate { all } => drivers::validate(all),
        Command::Integrations { only } => integrations::run(only.as_deref()),
        Command::View(arguments) => view::run(&arguments),
        Command::Soak(options) => soak::run(&options),
        Command::Fuzz(options) => fuzz::run(&options),
        Command::Mutants(options) => mutants::run(&options),
        Command::Web(options) => web::run(options),
        Command::Help => {
            print!("{HELP}");
            Ok(true)
        }
    }
}

fn parse(arguments: &[String]) -> Result<Command, String> {
    let (name, rest) = arguments.split_first().ok_or("a command is missing")?;
    let command = match name.as_str() {
        "demo" => Command::Demo,
        "test" => Command::Test,
        "scenes" => Command::Scenes { check: false },
        "gallery" => Command::Gallery,
        "cameras" => Command::Cameras { seed: 1 },
        "colors" => Command::Colors,
        "figures" => return figures_options(rest),
        "drivers" => return drivers_options(rest),
        "validate" => Command::Validate { all: false },
        "integrations" => Command::Integrations { only: None },
        "view" => return Ok(Command::View(rest.to_vec())),
        "soak" => return soak_options(rest),
        "fuzz" => return fuzz_options(rest),
        "mutants" => return mutants_options(rest),
        "web" => return web_options(rest),
        "help" | "--help" | "-h" => return Ok(Command::Help),
        other => return Err(format!("there is no command `{other}`")),
    };
    match rest {
        [] => Ok(command),
        [all] if name == "validate" && all == "--all" => Ok(Command::Validate { all: true }),
        [check] if name == "scenes" && check == "--check" => Ok(Command::Scenes { check: true }),
        [seed, value] if name == "cameras" && seed == "--seed" => {
            Ok(Command::Cameras { seed: number(seed, Some(value))? })
        }
        [only] if name == "integrations" && integrations::names().any(|known| known == only) => {
            Ok(Command::Integrations { only: Some(only.clone()) })
        }
        [help] if help == "--help" || help == "-h" => Ok(Command::Help),
        [extra, ..] => Err(format!("`{name}` takes no argument `{extra}`")),
    }
}

fn figures_options(rest: &[String]) -> Result<Command, String> {
    let mut options = figures::Options::default();
    for word in rest {
        match word.as_str() {
            "--gpu" => options.gpu = true,
            "--help" | "-h" => return Ok(Command::Help),
            text if options.only.is_none() && !text.starts_with('-') => options.only = Some(text.to_owned()),
            extra => return Err(format!("`figures` takes no argument `{extra}`")),
        }
    }
    Ok(Command::Figures(options))
}

fn drivers_options(rest: &[String]) -> Result<Command, String> {
    let mut options = drivers::Options::default();
    let mut rest = rest.iter();
    while let Some(name) = rest.next() {
        match name.as_str() {
            "--quick" => options.quick = true,
            "--only" => options.only = Some(rest.next().ok_or("`--only` needs a pipeline")?.clone()),
            "--minutes" => options.minutes = Some(number(name, rest.next())?),
            "--help" | "-h" => return Ok(Command::Help),
            extra => return Err(format!("`drivers` takes no argument `{extra}`")),
        }
    }
    Ok(Command::Drivers(options))
}

fn soak_options(rest: &[String]) -> Result<Command, String> {
    let mut options = soak::Options::default();
    let mut rest = rest.iter();
    while let Some(name) = rest.next() {
        match name.as_str() {
            "--seconds" => options.seconds = Some(number(name, rest.next())?),
            "--cases" => options.times = Some(number(name, rest.next())?),
            "--seed" => options.seed = Some(number(name, rest.next())?),
            "--help" | "-h" => return Ok(Command::Help),
            extra => return Err(format!("`soak` takes no argument `{extra}`")),
        }
    }
    Ok(Command::Soak(options))
}

fn mutants_options(rest: &[String]) -> Result<Command, String> {
    let mut options = mutants::Options::default();
    let mut rest = rest.iter();
    while let Some(name) = rest.next() {
        match name.as_str() {
            "--rust" => options.rust = true,
            "--sample" => options.sample = Some(number(name, rest.next())?),
            "--seed" => options.seed = Some(number(name, rest.next())?),
            "--jobs" => options.jobs = Some(number(name, rest.next())?),
            "--in" => options.within = Some(rest.next().ok_or("`--in` needs a name")?.clone()),
            "--help" | "-h" => return Ok(Command::Help),
            extra => return Err(format!("`mutants` takes no argument `{extra}`")),
        }
    }
    Ok(Command::Mutants(options))
}

fn fuzz_options(rest: &[String]) -> Result<Command, String> {
    let mut options = fuzz::Options::default();
    let mut rest = rest.iter();
    while let Some(name) = rest.next() {
        match name.as_str() {
            "--minutes" => options.minutes = Some(number(name, rest.next())?),
            "--target" => options.target = Some(rest.next().ok_or("`--target` needs a name")?.clone()),
            "--page" => options.page = true,
            "--help" | "-h" => return Ok(Command::Help),
            extra => return Err(format!("`fuzz` takes no argument `{extra}`")),
        }
    }
    Ok(Command::Fuzz(options))
}

fn web_options(rest: &[String]) -> Result<Command, String> {
    let mut options = web::Options::default();
    for name in rest {
        match name.as_str() {
            "--test" => options.test = true,
            "--serve" => options.serve = true,
            "--help" | "-h" => return Ok(Command::Help),
            extra => return Err(format!("`web` takes no argument `{extra}`")),
        }
    }
    Ok(Command::Web(options))
}

fn number<T: std::str::FromStr>(name: &str, value: Option<&String>) -> Result<T, String> {
    let value = value.ok_or_else(|| format!("`{name}` needs a number"))?;
    value.parse().map_err(|_| format!("`{name}` needs a number, not `{value}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Command, String> {
        parse(&line.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn each_command_is_understood() {
        assert_eq!(parsed("demo"), Ok(Command::Demo));
        assert_eq!(parsed("test"), Ok(Command::Test));
        assert_eq!(parsed("scenes"), Ok(Command::Scenes { check: false }));
        assert_eq!(parsed("scenes --check"), Ok(Command::Scenes { check: true }));
        assert_eq!(parsed("validate --all"), Ok(Command::Validate { all: true }));
        assert_eq!(parsed("gallery"), Ok(Command::Gallery));
        assert_eq!(parsed("colors"), Ok(Command::Colors));
        assert_eq!(parsed("cameras --seed 7"), Ok(Command::Cameras { seed: 7 }));
        let figures = figures::Options { only: Some("session".to_owned()), gpu: true };
        assert_eq!(parsed("figures session --gpu"), Ok(Command::Figures(figures)));
        assert_eq!(parsed("integrations"), Ok(Command::Integrations { only: None }));
        let only = Some("umbra".to_owned());
        let drivers = drivers::Options { only, minutes: Some(20), ..drivers::Options::default() };
        assert_eq!(parsed("drivers --only umbra --minutes 20"), Ok(Command::Drivers(drivers)));
        let only = Some("bevy".to_owned());
        assert_eq!(parsed("integrations bevy"), Ok(Command::Integrations { only }));
        assert!(parsed("integrations bvey").is_err());
        let arguments = ["p.json", "--help"].map(str::to_owned).to_vec();
        assert_eq!(parsed("view p.json --help"), Ok(Command::View(arguments)));
        let soak = soak::Options { seconds: Some(60), times: Some(100), seed: None };
        assert_eq!(parsed("soak --seconds 60 --cases 100"), Ok(Command::Soak(soak)));
        let mutants = mutants::Options { sample: Some(9), jobs: Some(2), ..mutants::Options::default() };
        assert_eq!(parsed("mutants --jobs 2 --sample 9"), Ok(Command::Mutants(mutants)));
        assert_eq!(parsed("web --test"), Ok(Command::Web(web::Options { test: true, serve: false })));
        for help in ["help", "--help", "-h", "test --help"] {
            assert_eq!(parsed(help), Ok(Command::Help), "{help}");
        }
    }

    #[test]
    fn anything_else_is_named_in_the_error() {
        assert!(parsed("").is_err());
        assert!(parsed("tset").unwrap_err().contains("`tset`"));
        assert!(parsed("test --fast").unwrap_err().contains("`--fast`"));
        assert!(parsed("test --check").unwrap_err().contains("`--check`"));
        assert!(parsed("figures --fast").unwrap_err().contains("`--fast`"));
        assert!(parsed("drivers --only").unwrap_err().contains("`--only`"));
        assert!(parsed("soak --cases many").unwrap_err().contains("`many`"));
        assert!(parsed("web --tset").unwrap_err().contains("`--tset`"));
        assert!(parsed("mutants --sample").unwrap_err().contains("`--sample`"));
    }
}
