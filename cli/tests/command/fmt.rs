//! `umbragraph fmt` as a user meets it: what is written, what is not, and the exit status.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use umbragraph_test_support::command::text;
use umbragraph_test_support::scratch::ScratchFolder;

const UGLY: &str = "{\"a\":1, // one\n\"b\":[1,2]}";
const PRETTY: &str = "{\n  \"a\": 1, // one\n  \"b\": [1, 2]\n}\n";

fn fmt(arguments: &[&str], input: &[u8]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.arg("fmt").args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the command");
    child.stdin.take().unwrap().write_all(input).unwrap();
    child.wait_with_output().unwrap()
}

#[track_caller]
fn gives(output: &Output, status: i32, standard_output: &str) {
    assert_eq!(text(&output.stdout), standard_output, "{}", text(&output.stderr));
    assert_eq!(output.status.code(), Some(status), "{}", text(&output.stderr));
}

/// Writes a text to a file in a folder, and returns the file's path.
fn file(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap().flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn files_are_formatted_in_place_and_only_if_needed() {
    let folder = ScratchFolder::new("fmt-in-place");
    let path = file(&folder, "a.json", UGLY);
    let marked = file(&folder, "marked.json", &format!("\u{feff}{PRETTY}"));
    let arguments = [path.to_str().unwrap(), marked.to_str().unwrap()];
    gives(&fmt(&arguments, b""), 0, "");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), PRETTY);
    assert_eq!(std::fs::read_to_string(&marked).unwrap(), PRETTY);

    let past = std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1_000_000_000);
    std::fs::File::options().write(true).open(&path).unwrap().set_modified(past).unwrap();
    gives(&fmt(&arguments, b""), 0, "");
    assert_eq!(std::fs::metadata(&path).unwrap().modified().unwrap(), past, "written without need");
    assert_eq!(names(&folder), ["a.json", "marked.json"], "nothing else is left");
}

#[test]
fn check_lists_what_would_change_and_writes_nothing() {
    let folder = ScratchFolder::new("fmt-check");
    let (ugly, pretty) = (file(&folder, "ugly.json", UGLY), file(&folder, "pretty.json", PRETTY));
    let (ugly_name, pretty_name) = (ugly.to_str().unwrap(), pretty.to_str().unwrap());
    gives(&fmt(&["--check", pretty_name, ugly_name], b""), 1, &format!("{ugly_name}\n"));
    assert_eq!(std::fs::read_to_string(&ugly).unwrap(), UGLY);
    gives(&fmt(&["--check", pretty_name], b""), 0, "");
    gives(&fmt(&["--check", "-"], UGLY.as_bytes()), 1, "<standard input>\n");
}

#[test]
fn check_shows_the_first_line_that_differs() {
    let says = |input: &str| text(&fmt(&["--check", "-"], input.as_bytes()).stderr);
    let wide = PRETTY.replace("\"b\": [1, 2]", "\"b\": [1,2]");
    assert_eq!(says(&wide), "<standard input>:3\n-   \"b\": [1,2]\n+   \"b\": [1, 2]\n");
    let one_end = "- }\n+ }\n\\ the last line has no line end\n";
    assert_eq!(says(PRETTY.trim_end()), format!("<standard input>:4\n{one_end}"));
    assert_eq!(says(&format!("\u{feff}{PRETTY}")), "<standard input>: begins with a byte-order mark\n");
    let windows = says(&PRETTY.replacen('\n', "\r\n", 1));
    assert!(windows.starts_with("<standard input>:1\n- {\\r\n+ {\n"), "{windows}");
    assert_eq!(says(PRETTY), "");
}

#[test]
fn standard_input_goes_to_standard_output() {
    gives(&fmt(&["-"], UGLY.as_bytes()), 0, PRETTY);
    gives(&fmt(&["-"], PRETTY.as_bytes()), 0, PRETTY);
    gives(&fmt(&["-"], format!("\u{feff}{UGLY}").as_bytes()), 0, PRETTY);
    let rejected = fmt(&["-"], b"{\"a\":");
    gives(&rejected, 1, "");
    assert!(text(&rejected.stderr).contains("UG0101"), "{}", text(&rejected.stderr));
    let rejected = fmt(&["-"], b"\"\xff\"");
    gives(&rejected, 1, "");
    assert!(text(&rejected.stderr).contains("UG0002"), "{}", text(&rejected.stderr));
}

#[test]
fn strict_prints_one_file_without_comments() {
    let folder = ScratchFolder::new("fmt-strict");
    let path = file(&folder, "a.json", UGLY);
    let name = path.to_str().unwrap();
    gives(&fmt(&["--strict", name], b""), 0, "{ \"a\": 1, \"b\": [1, 2] }\n");
    gives(&fmt(&["--strict", "-"], UGLY.as_bytes()), 0, "{ \"a\": 1, \"b\": [1, 2] }\n");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), UGLY);
    for arguments in [vec!["--strict", name, name], vec!["--strict", "--check", name], vec![]] {
        gives(&fmt(&arguments, b""), 2, "");
    }
}

#[test]
fn a_file_that_cannot_be_formatted_stops_no_other_file() {
    let folder = ScratchFolder::new("fmt-broken");
    let broken = file(&folder, "broken.json", "{\"a\":1,}");
    let missing = folder.join("missing.json");
    let ugly = file(&folder, "ugly.json", UGLY);
    let arguments = [broken.to_str().unwrap(), missing.to_str().unwrap(), ugly.to_str().unwrap()];
    let output = fmt(&arguments, b"");
    gives(&output, 1, "");
    let errors = text(&output.stderr);
    assert!(errors.contains("UG0101") && errors.contains("broken.json:1:"), "{errors}");
    assert!(errors.contains("UG0001") && errors.contains("missing.json"), "{errors}");
    assert_eq!(std::fs::read_to_string(&broken).unwrap(), "{\"a\":1,}");
    assert_eq!(std::fs::read_to_string(&ugly).unwrap(), PRETTY);
}

#[test]
fn a_file_that_cannot_be_replaced_stays_and_is_reported() {
    let folder = ScratchFolder::new("fmt-unwritable");
    // So long a name leaves no room for that of a temporary file beside it, whoever runs this.
    let path = file(&folder, &format!("{}.json", "x".repeat(250)), UGLY);
    let output = fmt(&[path.to_str().unwrap()], b"");
    gives(&output, 1, "");
    assert!(text(&output.stderr).contains("UG0004"), "{}", text(&output.stderr));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), UGLY);
    assert_eq!(names(&folder).len(), 1);
}

#[cfg(unix)]
#[test]
fn a_folder_that_is_read_only_is_a_diagnostic() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = ScratchFolder::new("fmt-read-only");
    let path = file(&folder, "a.json", UGLY);
    let permit = |mode| std::fs::set_permissions(&*folder, std::fs::Permissions::from_mode(mode)).unwrap();
    permit(0o555);
    // Nothing is read-only to an administrator.
    let is_administrator = std::fs::write(folder.join("probe"), "").is_ok();
    let output = fmt(&[path.to_str().unwrap()], b"");
    permit(0o755);
    if is_administrator {
        gives(&output, 0, "");
        return;
    }
    gives(&output, 1, "");
    assert!(text(&output.stderr).contains("UG0004"), "{}", text(&output.stderr));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), UGLY);
}

#[cfg(unix)]
#[test]
fn links_and_permissions_stay() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = ScratchFolder::new("fmt-links");
    let path = file(&folder, "a.json", UGLY);
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o640)).unwrap();
    let link = folder.join("link.json");
    std::os::unix::fs::symlink("a.json", &link).unwrap();
    gives(&fmt(&[link.to_str().unwrap()], b""), 0, "");
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(std::fs::read_to_string(&path).unwrap(), PRETTY);
    assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
}

#[test]
fn every_pipeline_of_the_tree_has_its_canonical_layout() {
    fn collect(folder: &Path, files: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                collect(&path, files);
            } else if path.extension().is_some_and(|extension| extension == "json") {
                files.push(path.to_str().unwrap().to_owned());
            }
        }
    }
    let mut files = vec!["--check".to_owned()];
    collect(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../pipelines"), &mut files);
    files.sort();
    assert!(files.len() > 20);
    let arguments: Vec<&str> = files.iter().map(String::as_str).collect();
    let output = fmt(&arguments, b"");
    gives(&output, 0, "");
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
}
