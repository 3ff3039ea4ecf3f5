//! A second opinion: an external validator on every distinct text.
//!
//! The command is a program and its arguments, with `{}` for the file: `tint --format wgsl -o /dev/null {}`. It is
//! started directly, never through a shell. What it prints goes to files, so a process that leaves children behind
//! cannot keep anybody waiting, and after the time limit it is killed: on Unix with all that it has started, as a
//! process group of its own, elsewhere alone. An interrupt from the terminal does not reach that group. An
//! exit status other than zero is a rejection; of its output,
//! the first `FILE:LINE:COLUMN` gives the place.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use std::{fs, io};

use umbragraph::diagnostic::Place;
use umbragraph::low_level::shader::permutations::{Opinion, Validator};

/// The command of an external validator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ExternalValidator {
    /// The command line as the user wrote it.
    pub(crate) text: String,
    pub(crate) program: String,
    pub(crate) arguments: Vec<String>,
    /// The time limit for one shader source.
    pub(crate) time_limit: Duration,
    /// The source place of the command on the command line, for diagnostics about the command itself.
    pub(crate) place: Place,
}

impl ExternalValidator {
    /// Parses a command line: words separated by white space, with single or double quotes around words that contain
    /// white space.
    ///
    /// # Errors
    /// The reason why the command line is invalid.
    pub(crate) fn parse(line: &str) -> Result<Self, &'static str> {
        let mut words: Vec<String> = Vec::new();
        let mut word: Option<String> = None;
        let mut quote = None;
        for character in line.chars() {
            match (quote, character) {
                (Some(open), close) if open == close => quote = None,
                (None, '"' | '\'') => {
                    quote = Some(character);
                    word.get_or_insert_default();
                }
                (None, space) if space.is_whitespace() => words.extend(word.take()),
                (_, other) => word.get_or_insert_default().push(other),
            }
        }
        if quote.is_some() {
            return Err("a quote in the command has no end");
        }
        words.extend(word);
        if words.is_empty() {
            return Err("the command is empty");
        }
        let program = words.remove(0);
        if !words.iter().any(|word| word.contains("{}")) {
            return Err("the command does not say where the file goes: write {} there");
        }
        let (text, time_limit) = (line.to_owned(), Duration::from_secs(10));
        Ok(Self { text, program, arguments: words, time_limit, place: Place::Nowhere })
    }

    fn run(&self, wgsl: &str, file: &Path, folder: &Path) -> io::Result<Option<ExitStatus>> {
        fs::write(file, wgsl)?;
        let name = file.to_string_lossy();
        let mut command = Command::new(&self.program);
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command
            .args(self.arguments.iter().map(|argument| argument.replace("{}", &name)))
            .stdin(Stdio::null())
            .stdout(fs::File::create(folder.join("stdout"))?)
            .stderr(fs::File::create(folder.join("stderr"))?)
            .spawn()?;
        let start = Instant::now();
        let mut pause = Duration::from_micros(500);
        loop {
            if let Some(status) = child.try_wait()? {
                return Ok(Some(status));
            }
            if start.elapsed() > self.time_limit {
                kill_with_children(&mut child);
                return Ok(None);
            }
            std::thread::sleep(pause);
            pause = (pause * 2).min(Duration::from_millis(20));
        }
    }
}

impl Validator for ExternalValidator {
    /// Returns the validator's name in diagnostics: the file name of its program.
    fn name(&self) -> &str {
        Path::new(&self.program).file_name().and_then(|name| name.to_str()).unwrap_or(&self.program)
    }

    fn place(&self) -> Place {
        self.place.clone()
    }

    /// Runs the command on a shader source and returns the verdict.
    fn judge(&self, wgsl: &str) -> Opinion {
        let folder = match TemporaryFolder::new() {
            Ok(folder) => folder,
            Err(error) => return Opinion::Unavailable(format!("no temporary folder can be made: {error}")),
        };
        let file = folder.path.join("shader.wgsl");
        match self.run(wgsl, &file, &folder.path) {
            Ok(Some(status)) if status.success() => Opinion::Accepts,
            Ok(Some(status)) => {
                let mut output = String::new();
                for name in ["stderr", "stdout"] {
                    let bytes = fs::read(folder.path.join(name)).unwrap_or_default();
                    output.push_str(&String::from_utf8_lossy(&bytes[..bytes.len().min(1 << 16)]));
                    output.push('\n');
                }
                rejection(&output, &file.to_string_lossy(), status)
            }
            Ok(None) => Opinion::TimedOut,
            Err(error) => Opinion::Unavailable(format!("\"{}\" cannot be started: {error}", self.program)),
        }
    }
}

/// Kills the leader of a process group, and on Unix the entire group.
fn kill_with_children(child: &mut Child) {
    // The process is not waited for yet, so its number, which is that of the group, belongs to nobody else.
    #[cfg(unix)]
    if let Some(group) = i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw) {
        let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
    }
    let _ = child.kill();
    let _ = child.wait();
}

fn rejection(output: &str, file: &str, status: ExitStatus) -> Opinion {
    let mut place = None;
    let mut message = None;
    for line in output.lines() {
        if let (None, Some((_, rest))) = (place, line.split_once(file)) {
            let mut parts = rest.trim_start_matches(':').split(':');
            let mut number = || {
                let digits: String = parts.next()?.chars().take_while(char::is_ascii_digit).collect();
                digits.parse::<usize>().ok()
            };
            if let (Some(at), Some(column)) = (number(), number()) {
                place = Some((at, column));
                let text = rest.trim_start_matches(|each: char| each == ':' || each.is_ascii_digit()).trim();
                if !text.is_empty() {
                    message = Some(text.to_owned());
                }
            }
        }
    }
    let first = output.lines().map(str::trim).find(|line| !line.is_empty()).map(str::to_owned);
    let message = message.or(first).unwrap_or_else(|| status.to_string());
    let message =
        message.strip_prefix("error:").unwrap_or(message.as_str()).trim().replace(file, "the module");
    Opinion::Rejects { message: message.chars().take(400).collect(), place }
}

struct TemporaryFolder {
    path: PathBuf,
}

impl TemporaryFolder {
    fn new() -> io::Result<Self> {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        for _ in 0..64 {
            let number = NEXT.fetch_add(1, Ordering::Relaxed);
            let path = std::env::temp_dir().join(format!("umbragraph-{}-{number}", std::process::id()));
            match fs::create_dir(&path) {
                Ok(()) => return Ok(Self { path }),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_words_with_quotes() {
        let validator = ExternalValidator::parse("/opt/tint --name 'a b' -o \"\" {}").unwrap();
        assert_eq!(validator.name(), "tint");
        assert_eq!(validator.arguments, ["--name", "a b", "-o", "", "{}"]);
        assert_eq!(ExternalValidator::parse(" "), Err("the command is empty"));
        assert_eq!(
            ExternalValidator::parse("tint x"),
            Err("the command does not say where the file goes: write {} there")
        );
        assert_eq!(ExternalValidator::parse("tint '{}"), Err("a quote in the command has no end"));
    }

    #[cfg(unix)]
    #[test]
    fn a_missing_a_crashing_and_a_hanging_validator_are_told_apart() {
        let judge = |line: &str| {
            let validator = ExternalValidator::parse(line).unwrap();
            ExternalValidator { time_limit: Duration::from_millis(300), ..validator }
                .judge("fn f() {}\nlet\n")
        };
        assert_eq!(judge("true {}"), Opinion::Accepts);
        assert!(matches!(judge("/nonexistent/validator {}"), Opinion::Unavailable(_)));
        assert_eq!(judge("sh -c 'sleep 30' {}"), Opinion::TimedOut);
        assert!(matches!(judge("sh -c 'kill -9 $$' {}"), Opinion::Rejects { place: None, .. }));
        assert_eq!(
            judge("sh -c 'echo $0:2:3 error: no such thing >&2; exit 1' {}"),
            Opinion::Rejects { message: "no such thing".to_owned(), place: Some((2, 3)) }
        );
    }

    #[cfg(unix)]
    #[test]
    fn what_a_hanging_validator_has_started_ends_with_it() {
        let folder = TemporaryFolder::new().unwrap();
        let number = folder.path.join("number");
        let line = format!("sh -c 'sleep 1000 & echo $! > {}; wait' {{}}", number.display());
        let time_limit = Duration::from_secs(1);
        let validator = ExternalValidator { time_limit, ..ExternalValidator::parse(&line).unwrap() };
        assert_eq!(validator.judge(""), Opinion::TimedOut);
        let number: i32 = fs::read_to_string(number).unwrap().trim().parse().unwrap();
        let process = rustix::process::Pid::from_raw(number).unwrap();
        // Whoever inherits it may take a while to notice that it has ended.
        let is_over = || {
            let state = fs::read_to_string(format!("/proc/{number}/stat")).unwrap_or_default();
            rustix::process::test_kill_process(process).is_err() || state.contains(") Z ")
        };
        assert!((0..500).any(|_| is_over() || {
            std::thread::sleep(Duration::from_millis(10));
            false
        }));
    }
}
