//! `umbragraph-fuzz`: random inputs for all that umbragraph reads, counted target by target.
//!
//! A [target](targets::TARGETS) is a function of random choices, or a test of the workspace that makes its cases
//! itself. The inputs of a target are numbered, and a number gives the same input again, so a run goes on where the
//! last one ended. Functions are tried in a process of their own (`worker`), which tells what ends in a panic, takes
//! longer than a second, or ends the process: its memory is limited to a gibibyte. A change of the files that a target
//! is about starts its count again, and leaves the other counts as they are.
//!
//! | command | what it does |
//! |---|---|
//! | `run [--minutes N] [--target NAME]` | tries inputs of all targets in turn, or of one |
//! | `worker NAME FIRST COUNT FOLDER` | tries inputs of one target in this process |
//! | `show NAME NUMBER` | prints an input |
//! | `page FILE` | writes the counts into a page, between two marks |
//!
//! Limits: memory and processor time are limited on Unix only. No coverage guides the choices.

mod campaign;
mod counts;
mod mutation;
mod page;
mod target;
mod targets;
mod worker;

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match command(&words) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

fn command(words: &[&str]) -> Result<bool, String> {
    match words {
        ["run", options @ ..] => {
            let (mut minutes, mut only) = (1.0, None);
            for option in options.chunks(2) {
                match option {
                    ["--minutes", number] => {
                        let read = number.parse().ok().filter(|number| (0.0..=1e6).contains(number));
                        minutes = read.ok_or_else(|| format!("--minutes is `{number}`, which is no time"))?;
                    }
                    [name @ ("--minutes" | "--target")] => return Err(format!("`{name}` needs a value")),
                    ["--target", name] => only = Some(targets::named(name)?),
                    other => return Err(format!("`{}` is no option of run", other.join(" "))),
                }
            }
            campaign::run(Duration::from_secs_f64(minutes * 60.0), only)
        }
        ["worker", name, first, count, folder] => {
            let number = |text: &str| text.parse().map_err(|_| format!("`{text}` is no number"));
            worker::run(targets::named(name)?, number(first)?, number(count)?, Path::new(folder))
        }
        ["show", name, number] => {
            let number = number.parse().map_err(|_| format!("`{number}` is no number"))?;
            worker::show(targets::named(name)?, number)
        }
        ["page", file] => page::write(Path::new(file)).map(|()| true),
        _ => Err("the commands are run, worker, show and page".to_owned()),
    }
}
